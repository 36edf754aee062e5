"""Which description of example-robot-data somebody means."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.exceptions.did_you_mean import nearest
from tsd_casadi.exceptions.values import InvalidValue
from tsd_casadi.proposal.feet import name_legs
from tsd_casadi.proposal.locks import FINGERS, named_locks
from tsd_casadi.robot.description import Description, read_description
from tsd_casadi.robot.description_changes import complete_joints
from tsd_casadi.robot.description_path import find_package
from tsd_casadi.robot.parsed_model import parse_model

DATA = "example-robot-data"
# what the folders of that package end with
ENDINGS = ("_description", "_data")


def find_in_package(
    name: str, feet: Sequence[str], patterns: Sequence[str], file: Path | None = None
) -> tuple[Path, list[str]]:
    """Find the URDF of a robot.

    Of several it is one that has both feet and what is to be locked; then with the
    fewest fingers, then with the most joints, then with the shortest name.

    Args:
        name: Folder of the package, its ending left out or not.
        feet: Names of links or frames.
        patterns: Joints to lock.
        file: How the path of the one that is meant ends, any if None.

    Returns:
        Its path, and what is to be said about the choice, a line each.

    Raises:
        InvalidValue: If the package is not installed, or has no such robot.
        RobotFileError: If none of its descriptions has the feet.
    """
    package = find_package(DATA)
    if package is None:
        raise InvalidValue(
            "--package", f"'{name}'", f"the package {DATA}: pip install {DATA} xacro"
        )
    robots = {folder.name: folder for folder in sorted((package / "robots").iterdir())}
    meant = [each for each in (name, *(name + ending for ending in ENDINGS)) if each in robots]
    if not meant:
        known = [_short(each) for each in robots]
        raise InvalidValue("--package", f"'{name}'", f"a robot of {DATA}, {nearest(name, known)}")
    folder = robots[meant[0]]
    ranked = []
    for path in sorted(folder.rglob("*.urdf")):
        if file is not None and not str(path).endswith(f"/{file}"):
            continue
        description = read_description(path, "urdf")
        if _has(description, feet, patterns):
            joints = _moving(description)
            fingers = sum(FINGERS.search(joint) is not None for joint in joints)
            ranked.append((fingers * (not patterns), -len(joints), len(path.name), path))
    if not ranked:
        raise RobotFileError(
            folder,
            "",
            f"has no URDF with {' and '.join(feet)}"
            + (f" and joints for --lock {' '.join(patterns)}" if patterns else ""),
            _hint(folder, feet),
        )
    chosen = min(ranked)[-1]
    others = [path.name for *_, path in ranked if path != chosen]
    notes = [f"description: {chosen.name} of {folder.name}"]
    if others:
        notes[0] += f"; there are also {', '.join(others)}, which FILE would name"
    return chosen, notes


def _short(folder: str) -> str:
    for ending in ENDINGS:
        folder = folder.removesuffix(ending)
    return folder


def _has(description: Description, feet: Sequence[str], patterns: Sequence[str]) -> bool:
    there = {*description.links(), *description.joints()}
    if not there.issuperset(feet):
        return False
    try:
        named_locks(description.path, _moving(description), patterns)
    except RobotFileError:
        return False
    return True


def _moving(description: Description) -> list[str]:
    return [name for name, j in description.joints().items() if j.get("type") != "fixed"]


def _hint(folder: Path, feet: Sequence[str]) -> str:
    descriptions = [read_description(path, "urdf") for path in sorted(folder.rglob("*.urdf"))]
    links = [link for description in descriptions for link in description.links()]
    named = "; ".join(f"for {foot} {nearest(foot, links)}" for foot in feet)
    return f"{named}{_legs(descriptions[0])}" if descriptions else named


def _legs(description: Description) -> str:
    """Name the ends of the legs, of a description with every joint."""
    complete_joints(description, description.path, _moving(description), {})
    return name_legs(parse_model(description))
