"""What a robot file adds to a description before it is parsed."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from xml.etree import ElementTree

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.exceptions.did_you_mean import nearest
from tsd_casadi.robot.description import CONTINUOUS, LIMITED, Description
from tsd_casadi.robot.robot_file_overrides import LinkFile

# Pinocchio turns a continuous joint into one with two coordinates; a joint that is
# locked or has limits is one of these instead
HALF_TURN = "3.141592653589793"
# of a joint that does not move, or has its own in the robot file
ANY_LIMITS = {"lower": "-" + HALF_TURN, "upper": HALF_TURN, "effort": "0", "velocity": "0"}


def complete_joints(
    description: Description,
    robot_file: Path,
    locked: Collection[str],
    given: Mapping[str, Collection[str]],
) -> None:
    """Give the joints of a URDF what its parser insists on, where the robot file has it.

    Args:
        locked: Joints that do not move.
        given: Joints for which the robot file gives 'effort', 'velocity', 'position'.

    Raises:
        RobotFileError: If a joint that moves lacks a limit, or turns without end.
    """
    for name, joint in description.joints().items():
        fixed = name in locked
        if joint.get("type") == CONTINUOUS:
            if not fixed and name not in given["position"]:
                raise RobotFileError(
                    description.path,
                    f"joint {name}",
                    "is continuous, it turns without end",
                    f"limits in {robot_file.name}, 'position: {{{name}: [-3.14, 3.14]}}', or "
                    f"'locked: {{{name}: 0.0}}'",
                )
            joint.set("type", "revolute")
        if joint.get("type") not in LIMITED:
            continue
        limit = joint.find("limit")
        if limit is None:
            limit = ElementTree.SubElement(joint, "limit")
        for attribute, any_value in ANY_LIMITS.items():
            field = {"lower": "position", "upper": "position"}.get(attribute, attribute)
            if limit.get(attribute) is not None:
                continue
            # a limit of position that is left out is zero to the parser
            needed = attribute == "effort" and not fixed and name not in given[field]
            if needed:
                raise RobotFileError(
                    description.path,
                    f"joint {name}, limit, effort",
                    "is missing",
                    f"a torque limit in N m, here or in {robot_file.name}, "
                    f"'effort: {{{name}: 50.0}}'",
                )
            if field != "position" or fixed or name in given[field]:
                limit.set(attribute, any_value)


def override_links(
    description: Description, robot_file: Path, links: Mapping[str, LinkFile]
) -> None:
    """Write other masses and inertias into a description.

    Raises:
        RobotFileError: If a link is not there, or has no inertia to keep a part of.
    """
    there = description.links()
    for name, link in links.items():
        if name not in there:
            raise RobotFileError(
                robot_file,
                f"links.{name}",
                f"is no link of {description.path.name}",
                nearest(name, there),
            )
        element = there[name]
        inertial = element.find("inertial")
        if inertial is None and None in (link.mass, link.com, link.inertia):
            raise RobotFileError(
                robot_file,
                f"links.{name}",
                f"leaves out what {description.path.name} has not either",
                "mass, com and inertia",
            )
        write = _write_urdf if description.kind == "urdf" else _write_mjcf
        write(element, inertial, link)


def _write_urdf(
    element: ElementTree.Element, inertial: ElementTree.Element | None, link: LinkFile
) -> None:
    if inertial is None:
        inertial = ElementTree.SubElement(element, "inertial")
    if link.mass is not None:
        _child(inertial, "mass").set("value", repr(link.mass))
    if link.com is not None:
        _child(inertial, "origin").set("xyz", _numbers(link.com))
    if link.inertia is not None:
        # axes of the link: the description's turned ones no longer count
        _child(inertial, "origin").set("rpy", "0 0 0")
        names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        for name, value in zip(names, link.inertia, strict=True):
            _child(inertial, "inertia").set(name, repr(value))


def _write_mjcf(
    element: ElementTree.Element, inertial: ElementTree.Element | None, link: LinkFile
) -> None:
    if inertial is None:
        inertial = ElementTree.SubElement(element, "inertial")
    if link.mass is not None:
        inertial.set("mass", repr(link.mass))
    if link.com is not None:
        inertial.set("pos", _numbers(link.com))
    if link.inertia is not None:
        for name in ("diaginertia", "quat", "axisangle", "xyaxes", "zaxis", "euler"):
            inertial.attrib.pop(name, None)
        inertial.set("fullinertia", _numbers(link.inertia))


def _child(element: ElementTree.Element, tag: str) -> ElementTree.Element:
    found = element.find(tag)
    return ElementTree.SubElement(element, tag) if found is None else found


def _numbers(values: tuple[float, ...]) -> str:
    return " ".join(map(repr, values))
