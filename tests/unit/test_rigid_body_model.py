"""Descriptions that are not quite right, and what the robot file can do about them."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import pytest

from tsd_casadi import Robot, load_robot
from tsd_casadi.exceptions import RobotFileError

WriteRobot = Callable[..., Path]

FINGER = (
    '<link name="{name}"><inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" '
    'ixy="0" ixz="0" iyz="0"/></inertial></link>'
    '<joint name="{joint}" type="{type}"><parent link="torso"/><child link="{name}"/>'
    '<origin xyz="0 0.2 0.3"/><axis xyz="0 0 1"/>{inside}</joint>'
)
LIMIT = '<limit lower="-1" upper="1" effort="5" velocity="3"/>'


def with_joint(
    inside: str = LIMIT, *, kind: str = "revolute", **names: str
) -> Callable[[str], str]:
    """Add a link to the torso."""
    names = {"name": "finger", "joint": "FINGER", **names}
    part = FINGER.format(type=kind, inside=inside, **names)
    return lambda text: text.replace("</robot>", part + "</robot>")


def error_of(path: Path) -> RobotFileError:
    with pytest.raises(RobotFileError) as caught:
        load_robot(path)
    return caught.value


def update(**sections: Any) -> Callable[[Any], object]:
    return lambda document: document.update(sections)


def lock(locked: dict[str, float]) -> Callable[[Any], None]:
    """Lock joints of the torso, of which no posture speaks then."""

    def edit(document: Any) -> None:
        document["locked"] = locked
        for posture in (document["home"], *document["postures"].values()):
            for joint in [name for name in posture if name.startswith("B_")]:
                del posture[joint]

    return edit


def test_a_locked_joint_becomes_part_of_what_carries_it(
    robot: Robot, write_robot: WriteRobot
) -> None:
    locked = load_robot(write_robot(update(locked={"FINGER": 0.3}), with_joint()))
    assert locked.joint_names == robot.joint_names
    assert locked.weight == pytest.approx(robot.weight + 0.1 * 9.81)
    assert locked.body_fingerprint != robot.body_fingerprint


def test_where_a_joint_is_locked_counts(write_robot: WriteRobot) -> None:
    one, other = (load_robot(write_robot(lock({"B_TFE": angle}))) for angle in (0.0, 0.4))
    assert one.n == other.n == 16
    assert one.body_fingerprint != other.body_fingerprint
    assert other.home_com[0] - one.home_com[0] > 0.03


def test_locks_match_by_regular_expression(write_robot: WriteRobot) -> None:
    assert load_robot(write_robot(lock({"B_.*": 0.0}))).n == 14


@pytest.mark.parametrize(
    ("locked", "said"),
    [
        ({"FINGR": 0.0}, "matches no joint"),
        ({"[": 0.0}, "is no regular expression"),
        ({"FINGER": 1.5}, "expected a value from -1 to 1 rad"),
        ({"FING": 0.0}, "matches no joint"),  # the whole name
    ],
)
def test_a_lock_that_cannot_be_is_told(
    locked: dict[str, float], said: str, write_robot: WriteRobot
) -> None:
    error = error_of(write_robot(update(locked=locked), with_joint()))
    assert said in str(error)
    assert error.field.startswith("locked.")


def test_home_does_not_speak_of_a_locked_joint(write_robot: WriteRobot) -> None:
    error = error_of(write_robot(update(locked={"L_KFE": 1.0})))
    assert error.field == "home.L_KFE"
    assert "is locked" in str(error)


def test_a_mimicking_joint_is_locked_or_refused(write_robot: WriteRobot, robot: Robot) -> None:
    mimic = with_joint(LIMIT + '<mimic joint="B_TR" multiplier="1"/>')
    error = error_of(write_robot(urdf=mimic))
    assert "joint FINGER mimics B_TR" in str(error)
    assert "'locked: {FINGER: 0.0}'" in str(error)
    assert load_robot(write_robot(update(locked={"FINGER": 0.0}), mimic)).n == robot.n


def test_a_continuous_joint_gets_limits_or_is_refused(
    write_robot: WriteRobot, robot: Robot
) -> None:
    continuous = with_joint('<limit effort="5" velocity="3"/>', kind="continuous")
    error = error_of(write_robot(urdf=continuous))
    assert "joint FINGER" in str(error) and "turns without end" in str(error)
    limited = load_robot(write_robot(update(position={"FINGER": [-3.0, 3.0]}), continuous))
    assert limited.n == robot.n + 1
    index = limited.joint_names.index("FINGER")
    assert limited.model.lowerPositionLimit[7 + index] == -3.0
    assert limited.torque_limit[index] == 5.0
    assert load_robot(write_robot(update(locked={"FINGER": 0.0}), continuous)).n == robot.n


@pytest.mark.parametrize("kind", ["planar", "floating"])
def test_a_joint_with_several_degrees_of_freedom_is_named(
    kind: str, write_robot: WriteRobot, robot: Robot
) -> None:
    error = error_of(write_robot(urdf=with_joint("", kind=kind)))
    assert "joint FINGER" in str(error)
    assert "lock it" in str(error)
    assert (
        load_robot(write_robot(update(locked={"FINGER": 0.0}), with_joint("", kind=kind))).n == 17
    )


@pytest.mark.parametrize(
    "inside",
    [
        "",
        '<limit lower="-1" upper="1" velocity="3"/>',
        '<limit lower="-1" upper="1" effort="0" velocity="3"/>',
    ],
    ids=["no limit", "no effort", "zero effort"],
)
def test_an_effort_that_is_missing_can_be_given(inside: str, write_robot: WriteRobot) -> None:
    given: dict[str, Any] = {"effort": {"FIN.*": 7.0}, "position": {"FINGER": [-1.0, 1.0]}}
    error = error_of(write_robot(urdf=with_joint(inside)))
    assert "FINGER" in str(error) and "effort" in str(error)
    robot = load_robot(write_robot(update(**given), with_joint(inside)))
    assert robot.torque_limit[robot.joint_names.index("FINGER")] == 7.0


def test_limits_the_wrong_way_round_are_named(write_robot: WriteRobot) -> None:
    swapped = with_joint(LIMIT.replace('"-1"', '"2"'))
    error = error_of(write_robot(urdf=swapped))
    assert "joint FINGER has limits from 2 to 1 rad" in str(error)
    load_robot(write_robot(update(position={"FINGER": [-1.0, 2.0]}), swapped))


def test_a_joint_left_out_of_home_has_to_allow_zero(write_robot: WriteRobot) -> None:
    error = error_of(write_robot(urdf=with_joint(LIMIT.replace('"-1"', '"0.2"'))))
    assert error.field == "home.FINGER"
    assert "since it is left out" in str(error)
    assert "from 0.2 to 1 rad" in str(error)


def test_limits_do_not_make_another_body(write_robot: WriteRobot, robot: Robot) -> None:
    other = load_robot(
        write_robot(
            update(
                effort={".*_KFE": 200.0},
                velocity={".*": 9.0},
                position={"B_TR": [-0.5, 0.5]},
                acceleration={"B_.*": 50.0},
            )
        )
    )
    assert other.body_fingerprint == robot.body_fingerprint
    assert other.formulation_fingerprint == robot.formulation_fingerprint
    assert other.torque_limit[other.joint_names.index("L_KFE")] == 200.0
    assert (other.model.upperVelocityLimit[6:] == 9.0).all()
    assert other.acceleration_limit[other.joint_names.index("B_TAA")] == 50.0
    assert other.acceleration_limit[other.joint_names.index("L_KFE")] == 500.0


def test_masses_and_inertias_make_another_body(write_robot: WriteRobot, robot: Robot) -> None:
    before = robot.source_path.read_bytes()
    links = {"torso": {"mass": 20.0, "com": [0.0, 0.0, 0.1], "inertia": [0.5, 0.4, 0.3, 0, 0, 0]}}
    other = load_robot(write_robot(update(links=links)))
    assert other.body_fingerprint != robot.body_fingerprint
    inertia = other.model.inertias[other.model.getJointId("B_TFE")]
    assert inertia.mass == pytest.approx(20.0)
    np.testing.assert_allclose(inertia.lever, [0, 0, 0.1], atol=1e-12)
    np.testing.assert_allclose(inertia.inertia, np.diag([0.5, 0.4, 0.3]), atol=1e-12)
    assert robot.source_path.read_bytes() == before


def test_what_is_left_out_of_a_link_stays(write_robot: WriteRobot, robot: Robot) -> None:
    other = load_robot(write_robot(update(links={"torso": {"mass": 20.0}})))
    joint = robot.model.getJointId("B_TFE")
    now, then = other.model.inertias[joint], robot.model.inertias[joint]
    np.testing.assert_allclose(now.lever, then.lever, atol=1e-12)
    np.testing.assert_allclose(now.inertia, then.inertia, atol=1e-12)


def test_a_link_that_is_not_there_is_told_with_those_it_resembles(write_robot: WriteRobot) -> None:
    error = error_of(write_robot(update(links={"trso": {"mass": 1.0}})))
    assert error.field == "links.trso"
    assert "torso" in error.expected


TORSO = '<link name="torso">.*?</link>'


def with_torso(**values: str) -> Callable[[str], str]:
    """Write other numbers into the torso's inertia."""

    def edit(text: str) -> str:
        block = re.search(TORSO, text, re.S)
        assert block is not None
        changed = block.group()
        for name, value in values.items():
            key = "value" if name == "mass" else name
            tag = "mass" if name == "mass" else "inertia"
            changed = re.sub(rf'(<{tag}\b[^>]*?\b{key}=")[^"]*', rf"\g<1>{value}", changed)
        return text.replace(block.group(), changed)

    return edit


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"mass": "-22"}, "negative"),
        ({"mass": "nan"}, "mass [nan] is not a float"),
        ({"ixx": "0", "iyy": "0", "izz": "0"}, "not positive definite"),
        ({"ixx": "-0.1"}, "not positive definite"),
        ({"ixx": "5.0"}, "triangle inequality"),
    ],
)
def test_an_impossible_link_is_named_with_what_to_write(
    values: dict[str, str], said: str, write_robot: WriteRobot
) -> None:
    error = error_of(write_robot(urdf=with_torso(**values)))
    assert said in str(error)
    if "nan" in said:
        return
    assert "torso" in error.field
    lines = re.search(r"links: \{torso: \{(.*)\}\}$", str(error))
    assert lines is not None
    # what the message says can be pasted
    found = re.search(r"inertia: \[(.*?)\]", lines.group())
    assert found is not None
    link: dict[str, Any] = {"inertia": [float(x) for x in found.group(1).split(",")]}
    if "mass" in lines.group():
        link["mass"] = 22.85
    load_robot(write_robot(update(links={"torso": link}), with_torso(**values)))


def test_a_joint_that_moves_nothing_is_named(write_robot: WriteRobot) -> None:
    massless = re.sub(r"<inertial>.*?</inertial>", "", FINGER, flags=re.S)
    part = massless.format(name="finger", joint="FINGER", type="revolute", inside=LIMIT)
    error = error_of(write_robot(urdf=lambda text: text.replace("</robot>", part + "</robot>")))
    assert error.field == "joint FINGER"
    assert "moves nothing that has a mass" in str(error)


def test_feet_that_press_more_than_the_weight_are_refused(write_robot: WriteRobot) -> None:
    error = error_of(write_robot(lambda d: d["contacts"][0].update(minimum_force=700.0)))
    assert error.field == "contacts"
    assert "the robot weighs" in str(error)


def test_a_link_counts_where_a_joint_has_its_name(write_robot: WriteRobot) -> None:
    renamed = write_robot(
        lambda d: d["tasks"][2].update(frame="B_TFE"),
        lambda text: text.replace('"torso"', '"B_TFE"'),
    )
    robot = load_robot(renamed)
    task = robot.description.tasks[2]
    frame = robot.model.frames[robot.frame_id(task.name)]
    assert robot.model.frames[frame.parentFrame].type == pinocchio.FrameType.BODY
    np.testing.assert_array_equal(frame.placement.homogeneous, np.eye(4))


def test_a_moving_joint_may_be_called_as_the_base_is(write_robot: WriteRobot) -> None:
    robot = load_robot(
        write_robot(urdf=lambda text: text.replace('"B_TR"', '"root_joint"'), edit=rename_home)
    )
    assert "root_joint" in robot.joint_names
    assert robot.n == 17


def rename_home(document: Any) -> None:
    if "B_TR" in document["home"]:
        document["home"]["root_joint"] = document["home"].pop("B_TR")


def test_a_sole_may_be_a_link_and_an_offset(write_robot: WriteRobot, robot: Robot) -> None:
    soles = [robot.model.frames[frame] for frame in robot.sole_frames]
    feet = [robot.model.frames[robot.bodies.find_frame(name)] for name in ("L_foot", "R_foot")]

    def edit(document: Any) -> None:
        for contact, sole, foot in zip(document["contacts"], soles, feet, strict=True):
            placement = foot.placement.inverse() * sole.placement
            rpy = pinocchio.rpy.matrixToRpy(placement.rotation)
            contact["frame"] = foot.name
            contact["offset"] = {"xyz": placement.translation.tolist(), "rpy": rpy.tolist()}

    other = load_robot(write_robot(edit))
    for mine, theirs in zip(
        other.sole_placements(robot.home.q), robot.sole_placements(robot.home.q), strict=True
    ):
        np.testing.assert_allclose(mine.homogeneous, theirs.homogeneous, atol=1e-12)
    assert other.body_fingerprint == robot.body_fingerprint
    assert other.formulation_fingerprint != robot.formulation_fingerprint


def test_a_base_that_is_not_upright_stands_upright(write_robot: WriteRobot, robot: Robot) -> None:
    """The base link's axes are turned; the robot in the world is the same."""
    turn = pinocchio.rpy.rpyToMatrix(0.3, -1.2, 2.0)
    path = write_robot(update(base_orientation=[0.3, -1.2, 2.0]), lambda text: turned(text, turn))
    other = load_robot(path)
    for mine, theirs in zip(
        other.sole_placements(other.home.q), robot.sole_placements(robot.home.q), strict=True
    ):
        np.testing.assert_allclose(mine.homogeneous, theirs.homogeneous, atol=1e-9)
    np.testing.assert_allclose(other.home_com, robot.home_com, atol=1e-9)
    assert "base_orientation" not in path.read_text() or other.weight == pytest.approx(robot.weight)


def turned(text: str, turn: np.ndarray) -> str:
    """Put a link with turned axes above the pelvis, and give it what the pelvis had."""
    rpy = " ".join(map(repr, map(float, pinocchio.rpy.matrixToRpy(turn.T))))
    base = (
        '<link name="turned"/><joint name="turned_fixed" type="fixed"><parent link="turned"/>'
        f'<child link="pelvis"/><origin rpy="{rpy}"/></joint></robot>'
    )
    return text.replace("</robot>", base)


def test_names_may_have_dashes_and_spaces(write_robot: WriteRobot, robot: Robot) -> None:
    def edit(document: Any) -> None:
        for posture in (document["home"], *document["postures"].values()):
            posture["L-KFE 1"] = posture.pop("L_KFE")
        document["contacts"][0]["frame"] = "L-sole"

    def urdf(text: str) -> str:
        return text.replace('"L_KFE"', '"L-KFE 1"').replace('"L_sole"', '"L-sole"')

    renamed = load_robot(write_robot(edit, urdf))
    assert renamed.joint_names == [
        "L-KFE 1" if name == "L_KFE" else name for name in robot.joint_names
    ]
    np.testing.assert_array_equal(renamed.home.q, robot.home.q)
    # not in the robot's own name, which is a part of keys
    error = error_of(write_robot(update(name="my-robot")))
    assert error.field == "name"
