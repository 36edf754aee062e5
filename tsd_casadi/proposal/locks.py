"""Which joints do not move in a proposed file, and why."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pinocchio

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.description import CONTINUOUS, Description
from tsd_casadi.robot.joint_patterns import matching_joints
from tsd_casadi.robot.parsed_model import parse_model

# what hands are made of, in the words of descriptions; they are only mentioned
FINGERS = re.compile(r"finger|thumb|gripper|hand_|_hand|knuckle|index|pinky|ring_|middle_\d", re.I)
# a joint that moves less of the robot's mass than this may be a finger: hands are 0.5 %
TINY = 2e-3


@dataclass
class Locks:
    """Joints that do not move, with what is to be told of it.

    Attributes:
        angles: By joint [rad].
        patterns: Regular expressions of the user, with the joints that they match.
        reasons: Why a joint is locked that nobody named, by joint.
        notes: A line each.
    """

    angles: dict[str, float] = field(default_factory=dict)
    patterns: dict[str, list[str]] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def lock(self, joints: Collection[str], reason: str) -> None:
        """Lock what is not locked yet, and note it."""
        new = [joint for joint in joints if joint not in self.angles]
        self.angles.update(dict.fromkeys(new, 0.0))
        self.reasons.update(dict.fromkeys(new, reason))
        if new:
            self.notes.append(f"locked because {reason}: {_some(new)}")


def named_locks(path: Path, joints: Sequence[str], patterns: Sequence[str]) -> Locks:
    """Lock what the user names.

    Args:
        path: The description, for errors.
        joints: Of the description, those that move.
        patterns: Names, or regular expressions that match whole names.

    Raises:
        RobotFileError: If one matches no joint or is no regular expression.
    """
    locks = Locks()
    for pattern in patterns:
        matched = matching_joints(path, f"--lock {pattern}", pattern, joints)
        locks.patterns[pattern] = matched
        locks.angles.update(dict.fromkeys(matched, 0.0))
    return locks


def lock_followers(locks: Locks, description: Description, joints: Sequence[str]) -> None:
    """Lock joints that mimic another."""
    followers = [joint for joint in joints if description.leader_of(joint) is not None]
    locks.lock(followers, "they mimic other joints, which no torque control can do")


def lock_unmovable(locks: Locks, path: Path, model: Any, legs: Collection[str]) -> None:
    """Lock joints without torque, or with nothing to move.

    Args:
        model: ``pinocchio.Model`` of all joints.
        legs: Joints between the base and the feet, which have to move.

    Raises:
        RobotFileError: If a joint of a leg has no torque.
    """
    data = model.createData()
    pinocchio.computeSubtreeMasses(model, data)
    weak, light = [], []
    for j in range(2, model.njoints):
        name = str(model.names[j])
        if name in locks.angles:
            continue
        if not model.upperEffortLimit[model.joints[j].idx_v] > 0:
            if name in legs:
                raise RobotFileError(
                    path,
                    f"joint {name}, limit, effort",
                    "is 0 in a leg",
                    f"its torque limit in N m there, or the joint locked: --lock {name}",
                )
            weak.append(name)
        elif not data.mass[j] > 0:
            light.append(name)
    locks.lock(weak, "their torque limit is 0 in the description")
    locks.lock(light, "they move nothing that has a mass")


def settle_angles(locks: Locks, description: Description) -> None:
    """Give each locked joint the angle next to zero that its limits allow."""
    for name in locks.angles:
        low, high = _limits_of(description, name)
        locks.angles[name] = min(max(0.0, low), high) if low <= high else 0.0


def _limits_of(description: Description, joint: str) -> tuple[float, float]:
    """Read a joint's limits as they are written; zero where there are none."""
    element = description.joints()[joint]
    if description.kind == "mjcf":  # those of its class are written elsewhere
        model = parse_model(deepcopy(description))
        place = model.joints[model.getJointId(joint)]
        if place.nq != 1:
            return 0.0, 0.0
        low, high = model.lowerPositionLimit[place.idx_q], model.upperPositionLimit[place.idx_q]
        return float(low), float(high)
    limit = element.find("limit")
    if limit is None or element.get("type") == CONTINUOUS:
        return 0.0, 0.0
    return float(limit.get("lower", "0")), float(limit.get("upper", "0"))


def suggest(model: Any, legs: Collection[str]) -> list[str]:
    """Name what looks like fingers among the joints that move, a line."""
    data = model.createData()
    pinocchio.computeSubtreeMasses(model, data)
    suspects = [
        name
        for j, name in list(enumerate(model.names))[2:]
        if name not in legs and (FINGERS.search(name) or data.mass[j] < TINY * data.mass[0])
    ]
    if not suspects:
        return []
    return [f"may be fingers or grippers, which --lock NAME takes out: {_some(suspects)}"]


def _some(names: Sequence[str], most: int = 6) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more
