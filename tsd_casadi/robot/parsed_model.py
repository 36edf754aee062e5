"""A description parsed by Pinocchio, with what its parsers say when they fail."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pinocchio

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.captured_stderr import captured_stderr
from tsd_casadi.robot.description import Description
from tsd_casadi.robot.mjcf_efforts import mjcf_efforts

BASE_JOINT = "root_joint"


def parse_model(description: Description) -> Any:
    """Parse links and joints.

    Returns:
        ``pinocchio.Model`` with a free-flyer base, as the description has it.

    Raises:
        RobotFileError: If the parser cannot, with its reason.
    """
    return _parse_urdf(description) if description.kind == "urdf" else _parse_mjcf(description)


def _parse_urdf(description: Description) -> Any:
    name = BASE_JOINT
    while name in description.joints():
        name = f"{name}_"
    try:
        with captured_stderr() as said:
            model = pinocchio.buildModelFromXML(
                description.text, pinocchio.JointModelFreeFlyer(), name
            )
    except (ValueError, RuntimeError, KeyError) as error:
        reason = _reason(said) or str(error)
        raise _error(description, f"cannot be parsed ({reason})", "a valid URDF") from error
    if any(line.startswith("Error") for line in said):
        # the parser goes on without what it could not read
        raise _error(description, f"cannot be parsed ({_reason(said)})", "a valid URDF")
    return model


def _parse_mjcf(description: Description) -> Any:
    _check_bodies(description)
    compiler = description.root.find("compiler")
    if compiler is not None:  # the copy that is parsed lies elsewhere
        for directory in ("meshdir", "texturedir", "assetdir"):
            if compiler.get(directory) is not None:
                place = description.path.parent / compiler.get(directory, "")
                compiler.set(directory, str(place.resolve()))
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / description.path.name
        copy.write_text(description.text, encoding="utf-8")
        try:
            with captured_stderr() as said:
                model = pinocchio.buildModelFromMJCF(str(copy))
        except Exception as error:  # Boost's errors among them
            reason = _reason(said) or " ".join(str(error).split())
            raise _error(description, f"cannot be parsed ({reason})", "a valid MJCF") from error
    for joint, effort in mjcf_efforts(description.root).items():
        if model.existJointName(joint):
            model.upperEffortLimit[model.joints[model.getJointId(joint)].idx_v] = effort
    return model


def _check_bodies(description: Description) -> None:
    """See to one base that floats, and one joint in each body."""
    worlds = description.root.findall("worldbody")
    bodies = [body for world in worlds for body in world.findall("body") if _moves(body)]
    if len(bodies) != 1:
        raise _error(
            description, f"has {len(bodies)} bodies that move in its world", "one, the robot's base"
        )
    (base,) = bodies
    if not [*base.findall("freejoint"), *base.findall("joint[@type='free']")]:
        base.insert(0, ElementTree.Element("freejoint", name=BASE_JOINT))
    for body in base.iter("body"):
        if len(body.findall("joint")) > 1:
            raise _error(
                description, f"body {body.get('name')} has several joints", "one joint in each body"
            )


def _moves(body: ElementTree.Element) -> bool:
    return any(True for tag in ("joint", "freejoint") for _ in body.iter(tag))


def _reason(said: Sequence[str]) -> str:
    """Join what a parser said, without the places in its own source."""
    lines = [line.removeprefix("Error:").strip() for line in said if "at line" not in line]
    return "; ".join(lines)


def _error(description: Description, found: str, expected: str) -> RobotFileError:
    return RobotFileError(description.path, "", found, expected)
