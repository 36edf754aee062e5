from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tsd_casadi import Robot, load_robot
from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.robot_file import read_robot_file
from tsd_casadi.robot.robot_file_sections import HardwareFile

Edit = Callable[[Any], object]
WriteRobot = Callable[..., Path]


def put(*keys: Any) -> Edit:
    *path, last, value = keys

    def edit(document: Any) -> None:
        for key in path:
            document = document[key]
        document[last] = value

    return edit


def drop(*keys: Any) -> Edit:
    *path, last = keys

    def edit(document: Any) -> None:
        for key in path:
            document = document[key]
        del document[last]

    return edit


# what is wrong, the field named, what else the message says
BROKEN: dict[str, tuple[Edit, str, str]] = {
    "missing name": (drop("name"), "name", "is missing"),
    "missing contacts": (drop("contacts"), "contacts", "is missing"),
    "missing friction": (drop("contacts", 1, "friction"), "contacts.1.friction", "is missing"),
    "missing gain": (drop("tasks", 0, "P"), "tasks.0.P", "is missing"),
    "missing frame gain": (drop("tasks", 1, "W"), "tasks.1.W", "is missing"),
    "unknown field": (put("colour", "red"), "colour", "is not a known field"),
    "misspelt field": (put("posture", "p", 1.0), "posture.p", "misspelling"),
    "misspelt task field": (put("tasks", 0, "w", 1.0), "tasks.0.w", "misspelling"),
    "unknown task type": (put("tasks", 0, "type", "com2"), "tasks.0", "'com', 'frame'"),
    "word for a number": (put("tasks", 0, "P", "stiff"), "tasks.0.P", "valid number"),
    "number for a list": (put("contacts", 0, "x", 0.1), "contacts.0.x", "valid tuple"),
    "three for a range": (put("contacts", 0, "x", [-1.0, 0.0, 1.0]), "contacts.0.x", "2 items"),
    "list for a mapping": (put("posture", [1, 2, 3]), "posture", "valid dictionary"),
    "word for an angle": (put("home", "L_KFE", "bent"), "home.L_KFE", "valid number"),
    "unknown axis": (put("tasks", 0, "axes", ["x", "rx"]), "tasks.0.axes.1", "'x', 'y' or 'z'"),
    "no contacts": (put("contacts", []), "contacts", "at least 1 item"),
    "no tasks": (put("tasks", []), "tasks", "at least 1 item"),
    "NaN gain": (put("tasks", 0, "D", math.nan), "tasks.0.D", "finite number"),
    "infinite gain": (put("tasks", 0, "D", math.inf), "tasks.0.D", "finite number"),
    "NaN angle": (put("home", "L_KFE", math.nan), "home.L_KFE", "finite number"),
    "infinite sole": (put("contacts", 0, "x", [-math.inf, 0.1]), "contacts.0.x.0", "finite"),
    "negative gain": (put("tasks", 2, "P", -1.0), "tasks.2.P", "greater than or equal to 0"),
    "zero friction": (put("contacts", 0, "friction", 0.0), "contacts.0.friction", "than 0"),
    "zero weight": (put("regularization", "force", 0.0), "regularization.force", "than 0"),
    "zero limit": (put("limits", "acceleration", 0.0), "limits.acceleration", "than 0"),
    "negative damping": (put("safe_torque", "D", -1.0), "safe_torque.D", "than or equal to 0"),
    "swapped amplitude": (
        put("motions", "squat", "amplitude", [0.08, 0.001]),
        "motions.squat.amplitude",
        "low value first",
    ),
    "swapped frequency": (
        put("motions", "squat", "frequency", [1.0, 0.05]),
        "motions.squat.frequency",
        "low value first",
    ),
    "swapped sole": (put("contacts", 1, "y", [0.05, -0.05]), "contacts.1.y", "low value first"),
    "sole beside its frame": (put("contacts", 0, "x", [0.1, 0.2]), "contacts.0", "around zero"),
    "duplicate contacts": (put("contacts", 1, "name", "left_foot"), "contacts", "'left_foot'"),
    "duplicate tasks": (put("tasks", 1, "name", "torso"), "tasks", "'torso'"),
    "task named as a contact": (put("tasks", 1, "name", "left_foot"), "tasks", "'left_foot'"),
    "name with a dot": (put("tasks", 1, "name", "torso.1"), "tasks.1.name", "match pattern"),
    "name with a slash": (put("name", "a/b"), "name", "match pattern"),
    "text in a posture": (
        put("postures", "tall", "L_KFE", "bent"),
        "postures.tall.L_KFE",
        "number",
    ),
    "NaN in a posture": (put("postures", "tall", "L_KFE", math.nan), "postures.tall.L_KFE", "fini"),
    "a posture named home": (put("postures", "home", {}), "postures.home", "another name"),
    "a posture with a slash": (put("postures", "a/b", {}), "postures.a/b", "match pattern"),
    "missing friction of a joint": (
        drop("hardware", "coulomb_friction"),
        "hardware.coulomb_friction",
        "is missing",
    ),
    "misspelt hardware": (put("hardware", "inertia", 0.1), "hardware.inertia", "misspelling"),
    **{
        f"negative {name}": (put("hardware", name, -1e-9), f"hardware.{name}", "than or equal to 0")
        for name in HardwareFile.model_fields
    },
    "infinite lag": (put("hardware", "torque_lag", math.inf), "hardware.torque_lag", "finite"),
    "a motion's range of one number": (
        put("motions", "squat", "height", [0.05]),
        "motions.squat.height",
        "is missing",
    ),
    "a word for a motion's range": (
        put("motions", "squat", "height", "high"),
        "motions.squat.height",
        "tuple",
    ),
    "an infinite range": (
        put("motions", "squat", "height", [-math.inf, 0.1]),
        "motions.squat.height.0",
        "finite",
    ),
    "squat on no task": (put("motions", "squat", "task", "x"), "motions.squat.task", "com"),
    **{
        f"reserved name {name}": (put("tasks", 1, "name", name), "tasks", f"'{name}'")
        for name in ("posture", "limits", "regularization", "safe_torque", "q", "v")
    },
}


@pytest.mark.parametrize("case", BROKEN)
def test_message_names_file_field_and_expectation(case: str, write_robot: WriteRobot) -> None:
    edit, field, told = BROKEN[case]
    path = write_robot(edit)
    with pytest.raises(RobotFileError) as caught:
        load_robot(path)
    assert caught.value.path == path
    assert field in caught.value.field
    message = str(caught.value)
    assert str(path) in message
    assert told in message
    assert caught.value.expected in message.partition("expected ")[2]


# what the file should refuse and does not, or what it says of the wrong field
@pytest.mark.parametrize(
    ("edit", "field"),
    [
        pytest.param(drop("tasks", 1, "frame"), "tasks.1.frame"),
        pytest.param(drop("contacts", 1, "frame"), "contacts.1.frame"),
        pytest.param(put("contacts", 1, "y", [0.05, -0.05]), "contacts.1.y"),
        pytest.param(put("tasks", 0, "axes", []), "tasks.0.axes"),
        pytest.param(put("tasks", 1, "axes", []), "tasks.1.axes"),
        pytest.param(put("tasks", 0, "axes", ["z", "z"]), "tasks.0.axes"),
        pytest.param(put("contacts", 0, "friction", True), "contacts.0.friction"),
    ],
)
def test_finer_points(edit: Edit, field: str, write_robot: WriteRobot) -> None:
    with pytest.raises(RobotFileError) as caught:
        load_robot(write_robot(edit))
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("name: [unclosed", "is not YAML"),
        ("\t- tab", "is not YAML"),
        ("- a\n- list", "holds no mapping"),
        ("", "holds no mapping"),
        ("just a word", "holds no mapping"),
    ],
)
def test_file_that_is_no_mapping(text: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(text)
    with pytest.raises(RobotFileError, match=told) as caught:
        read_robot_file(path)
    assert str(path) in str(caught.value)


def test_file_that_is_not_text(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_bytes(b"\xff\xfe\x00name")
    with pytest.raises(RobotFileError, match="cannot be read"):
        read_robot_file(path)


def test_folder_for_a_file(tmp_path: Path) -> None:
    with pytest.raises(RobotFileError, match="cannot be read"):
        read_robot_file(tmp_path)


def test_unedited_copy_is_read_like_the_shipped_file(robot: Robot, write_robot: WriteRobot) -> None:
    assert read_robot_file(write_robot()) == robot.description


def test_axes_default_to_all(write_robot: WriteRobot) -> None:
    description = read_robot_file(write_robot(drop("tasks", 1, "axes")))
    assert description.tasks[0].axes == ("x", "y", "z")
    assert description.tasks[1].axes == ("x", "y", "z", "rx", "ry", "rz")


def test_optional_sections_may_be_left_out(write_robot: WriteRobot) -> None:
    def leave_out(document: Any) -> None:
        del document["postures"], document["hardware"], document["motions"]

    description = read_robot_file(write_robot(leave_out))
    assert description.postures == {}
    assert description.hardware is None
    assert description.motions == {}


def test_motions_say_ranges_and_maybe_a_task(write_robot: WriteRobot) -> None:
    motions = {"squat": {"task": "com", "amplitude": [0.01, 0.02]}, "sway": {"frequency": [0.1, 1]}}
    description = read_robot_file(write_robot(put("motions", motions)))
    squat, sway = description.motions["squat"], description.motions["sway"]
    assert (squat.task, squat.ranges) == ("com", {"amplitude": (0.01, 0.02)})
    assert (sway.task, sway.ranges) == (None, {"frequency": (0.1, 1.0)})


def test_hardware_without_any_effect_is_allowed(write_robot: WriteRobot) -> None:
    none = dict.fromkeys(HardwareFile.model_fields, 0.0)
    assert read_robot_file(write_robot(put("hardware", none))).hardware == HardwareFile(**none)


def test_numbers_with_a_bare_exponent_are_numbers(write_robot: WriteRobot) -> None:
    path = write_robot()
    path.write_text(path.read_text().replace("force: 1.0e-06", "force: 1e-6"))
    assert "force: 1e-6" in path.read_text()
    assert read_robot_file(path).regularization.force == 1e-6


def test_misspelled_field_is_named_and_not_the_missing_one(write_robot: WriteRobot) -> None:
    def misspell(document: Any) -> None:
        document["limit"] = document.pop("limits")

    with pytest.raises(RobotFileError, match="misspelling") as caught:
        load_robot(write_robot(misspell))
    assert caught.value.field == "limit"


@pytest.mark.parametrize(
    "line",
    [
        "when: 2024-99-99",
        "number: 0b_",
        "number: !!int ''",
        "number: !!float x",
        "switch: !!bool x",
        "when: !!timestamp x",
        f"number: {'9' * 5000}",
    ],
    ids=lambda line: line[:20],
)
def test_what_the_yaml_library_trips_over_is_told(line: str, tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(f"name: a\n{line}\n")
    with pytest.raises(RobotFileError, match="is not YAML") as caught:
        read_robot_file(path)
    assert caught.value.path == path
