"""Joints of a description that a robot file can be proposed with: limits, types and axes."""

from __future__ import annotations

import math
from collections.abc import Collection
from copy import deepcopy
from typing import Any
from xml.etree import ElementTree

import numpy as np

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.proposal.efforts import NONE
from tsd_casadi.robot.description import CONTINUOUS, LIMITED, Description
from tsd_casadi.robot.parsed_model import parse_model

# a limit further than this is in degrees, or of a joint that turns more than once [rad]
TURN = 2 * math.pi
# more names than these are counted
FEW = 6


def fill_efforts(description: Description) -> None:
    """Write 'none' where a URDF's joint has no torque limit: one is assumed later."""
    if description.kind != "urdf":
        return
    for joint in description.joints().values():
        if joint.get("type") not in (*LIMITED, CONTINUOUS):
            continue
        limit = joint.find("limit")
        if limit is None:
            limit = ElementTree.SubElement(joint, "limit")
        if limit.get("effort") is None:
            limit.set("effort", repr(NONE))


def check_joints(description: Description, locked: Collection[str]) -> None:
    """Refuse joints that move and have no usable limits, type or axis.

    Args:
        locked: Joints that do not move.

    Raises:
        RobotFileError: If there is one; it names the joint, and what ``tsd robot new``
            has for it.
    """
    wrong = _wrong_in_urdf if description.kind == "urdf" else _wrong_in_mjcf
    found = wrong(description, locked)
    if found is None:
        return
    joint, what, expected = found
    raise RobotFileError(
        description.path,
        f"joint {joint}",
        what,
        f"{expected} in the description, or the joint not to move: --lock {joint}",
    )


def _wrong_in_urdf(description: Description, locked: Collection[str]) -> Any:
    for name, joint in description.joints().items():
        kind = joint.get("type", "")
        if name in locked or kind == "fixed":
            continue
        if kind not in (*LIMITED, CONTINUOUS):
            return name, f"is of the type '{kind}'", f"one of {', '.join((*LIMITED, CONTINUOUS))}"
        axis = joint.find("axis")
        if axis is not None and not any(_numbers(axis.get("xyz", "1 0 0"))):
            return name, f"has the axis {axis.get('xyz')}", '<axis xyz="0 1 0"/> or the like'
        if kind == CONTINUOUS:
            continue
        limit = joint.find("limit")
        ends = [None if limit is None else limit.get(end) for end in ("lower", "upper")]
        wanted = '<limit lower="-1" upper="1" .../> in rad, the lower one first,'
        if ends == [None, None]:
            return name, "has no limits (lower and upper)", wanted
        low, high = (float((_numbers(end or "0") or [0.0])[0]) for end in ends)
        if not low < high:
            return name, f"has limits from {low:g} to {high:g} rad", wanted
    return None


def _wrong_in_mjcf(description: Description, locked: Collection[str]) -> Any:
    model = parse_model(deepcopy(description))
    for j in range(2, model.njoints):
        name, joint = str(model.names[j]), model.joints[j]
        if name in locked:
            continue
        if (joint.nq, joint.nv) != (1, 1):
            kind = joint.shortname().removeprefix("JointModel")
            return name, f"is of the type {kind}", "a hinge or slide with a range"
        low, high = model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]
        if not low < high:
            return name, f"has limits from {low:g} to {high:g} rad", "a range, the low value first,"
    return None


def check_followers(
    description: Description, model: Any, frames: Collection[str], locked: Collection[str]
) -> None:
    """Refuse a leg with a joint that mimics another one.

    Args:
        model: ``pinocchio.Model`` of all joints.
        frames: Links of the feet, or frames on them.
        locked: Joints that the user locks himself.

    Raises:
        RobotFileError: If there is one; it names the joint.
    """
    feet = {frame.parentJoint for frame in model.frames if frame.name in frames}
    for j in sorted({j for foot in feet for j in list(model.supports[foot])} - {0, 1}):
        name = str(model.names[j])
        leader = description.leader_of(name)
        if leader is not None and name not in locked:
            raise RobotFileError(
                description.path,
                f"joint {name}",
                f"mimics {leader}, in a leg",
                "a motor for each joint of the legs: the description without <mimic> there, or "
                f"the joint fixed: --lock {name}",
            )


def odd_limits(model: Any) -> list[str]:
    """Tell of limits that nobody has meant like that, a line each.

    Args:
        model: ``pinocchio.Model`` of the joints that move, each with one coordinate.
    """
    turned, still = [], []
    for j in range(2, model.njoints):
        name, joint = str(model.names[j]), model.joints[j]
        ends = np.array(
            [model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]]
        )
        slides = joint.shortname().removeprefix("JointModel").startswith("P")
        if not slides and np.isfinite(ends).all() and np.abs(ends).max() > TURN:
            turned.append(f"{name} [{ends[0]:g}, {ends[1]:g}]")
        if model.upperVelocityLimit[joint.idx_v] == 0:
            still.append(name)
    notes = []
    if turned:
        notes.append(f"limits beyond a whole turn, are they in degrees? {_some(turned)}")
    if still:
        notes.append(f"velocity limits of 0, which no motor has: {_some(still)}")
    return notes


def _numbers(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split()]
    except ValueError:
        return [math.nan]


def _some(names: list[str]) -> str:
    more = f" and {len(names) - FEW} more" if len(names) > FEW else ""
    return ", ".join(names[:FEW]) + more
