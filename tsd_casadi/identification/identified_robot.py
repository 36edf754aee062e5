"""A robot's files with other inertias."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.description_path import PACKAGE
from tsd_casadi.robot.robot import Robot, load_robot

FIXED = "fixed"
INERTIA_ENTRIES = {
    "ixx": (0, 0),
    "ixy": (0, 1),
    "ixz": (0, 2),
    "iyy": (1, 1),
    "iyz": (1, 2),
    "izz": (2, 2),
}


def write_robot(robot: Robot, inertias: Sequence[Any], folder: Path) -> Robot:
    """Copy a robot's folder and give its links other inertias.

    Everything else stays, the simulator's scene too: it is still that of the
    robot copied, so simulate with that one.

    Args:
        inertias: ``pinocchio.Inertia`` of each joint's body, base first; links
            on fixed joints belong to the body that carries them.
        folder: Where to; made if need be.

    Returns:
        The robot in the new folder.

    Raises:
        RobotFileError: If what was written cannot be used.
    """
    # what is written must be the copy, and the copy must find it
    source = robot.description.source
    if robot.description.urdf is None or source.startswith(PACKAGE):
        raise RobotFileError(
            robot.path,
            "urdf",
            f"is '{source}', which cannot be copied with other inertias",
            "a URDF in the robot file's folder, for the folder is copied",
        )
    shutil.copytree(robot.path.parent, folder, dirs_exist_ok=True)
    tree = ElementTree.parse(robot.source_path)
    links = {link.get("name"): link for link in tree.iter("link")}
    names = [None, *list(robot.model.names)[2:]]
    bodies = dict(zip(names, inertias, strict=True))
    locked = {robot.bodies.full.names[index] for index in robot.bodies.locked}
    children = set()
    for joint in tree.getroot().findall("joint"):
        child = _child(joint)
        children.add(child)
        if joint.get("type") == FIXED or joint.get("name") in locked:
            _remove_inertia(links[child])
        else:
            _set_inertia(links[child], bodies[joint.get("name")])
    (root,) = set(links) - children
    _set_inertia(links[root], bodies[None])
    path = folder / robot.path.name
    place = robot.source_path.resolve().relative_to(robot.path.parent.resolve())
    tree.write(folder / place, xml_declaration=True, encoding="utf-8")
    return load_robot(path)


def _child(joint: ElementTree.Element) -> str | None:
    child = joint.find("child")
    assert child is not None  # the URDF was parsed before
    return child.get("link")


def _remove_inertia(link: ElementTree.Element) -> None:
    for inertial in link.findall("inertial"):
        link.remove(inertial)


def _set_inertia(link: ElementTree.Element, inertia: Any) -> None:
    _remove_inertia(link)
    inertial = ElementTree.SubElement(link, "inertial")
    center = " ".join(repr(float(x)) for x in inertia.lever)
    ElementTree.SubElement(inertial, "origin", xyz=center, rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=repr(float(inertia.mass)))
    entries = {name: repr(float(inertia.inertia[place])) for name, place in INERTIA_ENTRIES.items()}
    ElementTree.SubElement(inertial, "inertia", entries)
