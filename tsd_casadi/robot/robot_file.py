"""The robot file: what a URDF does not say, written and checked as YAML."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.robot_file_fallback import FallbackFile, HoldFile
from tsd_casadi.robot.robot_file_goals import DemoGoalsFile
from tsd_casadi.robot.robot_file_overrides import OverridesFile
from tsd_casadi.robot.robot_file_sections import (
    AnyContact,
    Finite,
    HardwareFile,
    LimitsFile,
    MotionFile,
    Name,
    PostureFile,
    RegularizationFile,
    SafeTorqueFile,
    SoleFile,
)
from tsd_casadi.robot.robot_file_tasks import (
    GAIN_KINDS,
    AnyTask,
    ComTaskFile,
    FrameTaskFile,
    PlacedTask,
    check_tasks,
)
from tsd_casadi.robot.strict_yaml import read_yaml


class RobotFile(OverridesFile):
    """A robot as its file describes it.

    Paths are relative to the robot file and stay inside its folder, or are
    'package://name/...' for a data package that is installed.

    Attributes:
        name: Name of the robot, one chunk of its network keys.
        urdf: URDF or xacro of links and joints; or else
        mjcf: MuJoCo's description of them.
        home: Joint angles of the home posture [rad]; joints left out are zero.
        contacts: The feet.
        all_tasks: What the file has under 'tasks'.
        posture: Null-space posture.
        regularization: Weights on forces and accelerations.
        limits: Limits beyond those of the description.
        safe_torque: What a failed tick answers with.
        motions: Narrower ranges of motions than the robot could reach, by name.
        scene: MuJoCo scene to simulate; made from the description where it is left out.
        postures: Other postures by name, joint angles as for home.
        hardware: What the real robot has beyond rigid bodies; None if unknown.
        fallback: What a client does in periods without a torque; a hold with gains
            from the robot's weight and height where it is left out.
        demo_goals: What the demonstration has to reach.
    """

    name: Name
    urdf: str | None = None
    mjcf: str | None = None
    home: dict[str, Finite]
    contacts: Annotated[tuple[AnyContact, ...], Field(min_length=1)]
    all_tasks: Annotated[tuple[AnyTask, ...], Field(min_length=1, alias="tasks")]
    posture: PostureFile
    regularization: RegularizationFile
    limits: LimitsFile
    safe_torque: SafeTorqueFile
    motions: dict[Name, MotionFile] = Field(default_factory=dict)
    scene: str | None = None
    postures: dict[Name, dict[str, Finite]] = Field(default_factory=dict)
    hardware: HardwareFile | None = None
    fallback: FallbackFile = Field(default_factory=HoldFile)
    demo_goals: DemoGoalsFile = Field(default_factory=DemoGoalsFile)

    @property
    def tasks(self) -> tuple[PlacedTask, ...]:
        """The Cartesian tasks: those that have a place to be at, which motions move."""
        return tuple(
            task for task in self.all_tasks if isinstance(task, (ComTaskFile, FrameTaskFile))
        )

    @property
    def source(self) -> str:
        """The path of links and joints as it is written."""
        return self.urdf or self.mjcf or ""


def read_robot_file(path: Path) -> RobotFile:
    """Read and check a robot file.

    Args:
        path: The YAML file.

    Returns:
        The checked description.

    Raises:
        RobotFileError: If the file cannot be read, is not YAML, or a field is
            missing, unknown, of the wrong type or out of range.
    """
    document = read_yaml(path)
    try:
        robot_file = RobotFile.model_validate(document)
    except ValidationError as error:
        # a misspelled field is also a missing one; the misspelling helps more
        errors = sorted(error.errors(), key=lambda item: item["type"] != "extra_forbidden")
        first = errors[0]
        location = list(first["loc"])
        if location[:1] in (["tasks"], ["contacts"]):
            del location[2:3]  # the part's type, which pydantic puts in between
        if location[:1] == ["tasks"]:
            location = [part for part in location if part not in GAIN_KINDS]
        if location[:1] == ["fallback"]:
            del location[1:2]  # and its kind
        field = ".".join(map(str, location)) or "robot"
        found = _describe(first["type"], first.get("input"))
        raise RobotFileError(path, field, found, _expectation(first)) from error
    _check_ranges(path, robot_file)
    return robot_file


def _describe(kind: str, value: object) -> str:
    if kind == "missing":
        return "is missing"
    if kind == "extra_forbidden":
        return "is not a known field"
    return f"is {value!r}"


def _expectation(error: Any) -> str:
    if error["type"] == "missing":
        return "a value for it"
    if error["type"] == "extra_forbidden":
        return "no such field (look for a misspelling)"
    message: str = error["msg"]
    return message[:1].lower() + message[1:]


def _check_ranges(path: Path, robot_file: RobotFile) -> None:
    if (robot_file.urdf is None) == (robot_file.mjcf is None):
        raise RobotFileError(
            path,
            "urdf",
            "is missing" if robot_file.urdf is None else "is there beside 'mjcf'",
            "one description of links and joints, 'urdf' or 'mjcf'",
        )
    ranges = [
        (f"motions.{motion}.{name}", bounds)
        for motion, part in robot_file.motions.items()
        for name, bounds in part.ranges.items()
    ]
    soles = [
        (index, contact)
        for index, contact in enumerate(robot_file.contacts)
        if isinstance(contact, SoleFile)
    ]
    ranges += [(f"position.{joint}", bounds) for joint, bounds in robot_file.position.items()]
    for index, contact in soles:
        ranges += [(f"contacts.{index}.x", contact.x), (f"contacts.{index}.y", contact.y)]
    if "home" in robot_file.postures:
        raise RobotFileError(
            path, "postures.home", "is home, which has its own field", "another name for it"
        )
    for field, (low, high) in ranges:
        if low >= high:
            raise RobotFileError(path, field, f"is [{low}, {high}]", "the low value first")
    for index, contact in soles:
        if not (contact.x[0] < 0 < contact.x[1] and contact.y[0] < 0 < contact.y[1]):
            raise RobotFileError(
                path,
                f"contacts.{index}",
                "the frame's origin is not inside the sole",
                "x and y ranges around zero",
            )
    check_tasks(path, robot_file.all_tasks, robot_file.contacts)
    names = [part.name for part in (*robot_file.contacts, *robot_file.all_tasks)]
    reserved = ("posture", "limits", "regularization", "safe_torque", "period", "q", "v")
    for name in names:
        if names.count(name) > 1 or name in reserved:
            raise RobotFileError(
                path,
                "contacts, tasks",
                f"the name '{name}' is used twice or reserved",
                f"unique names other than {', '.join(reserved)}",
            )
    tasks = [task.name for task in robot_file.tasks]
    for motion, part in robot_file.motions.items():
        if part.task is not None and part.task not in tasks:
            raise RobotFileError(
                path, f"motions.{motion}.task", f"is '{part.task}'", f"one of {', '.join(tasks)}"
            )
