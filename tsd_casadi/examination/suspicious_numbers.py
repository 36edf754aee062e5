"""Limits of joints that look as if nobody had meant them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from tsd_casadi.examination.finding import Finding
from tsd_casadi.robot.robot import Robot

# so many joints do not have one motor by chance
FEW_JOINTS = 4
# a joint of a standing robot carries at most its weight at an arm as long as it is high;
# motors have up to three times what the weight needs
TORQUE_SHARE = 3.0
# a revolute joint turns once, cables allow no more
TURN = 2 * math.pi
# rounded angles of twin joints differ by less [rad]
ROUNDING = 0.02
TWINS = (("left", "right"), ("l", "r"))


def suspicious_numbers(robot: Robot) -> list[Finding]:
    """Look for limits that are placeholders or belong to other joints."""
    return [*_one_effort(robot), *_high_efforts(robot), *_ranges(robot), *_twins(robot)]


def _one_effort(robot: Robot) -> Iterator[Finding]:
    limits = robot.torque_limit
    if robot.n >= FEW_JOINTS and np.ptp(limits) == 0:
        yield Finding(
            "warning",
            "effort",
            f"is {limits[0]:g} N m for every joint, ankles and hips alike",
            "the motors' torques, in the robot file 'effort: {pattern: N m}'",
        )


def _high_efforts(robot: Robot) -> Iterator[Finding]:
    highest = TORQUE_SHARE * robot.weight * float(robot.home_com[2])
    for joint, limit in zip(robot.joint_names, robot.torque_limit, strict=True):
        if limit > highest and _turns(robot, joint):
            yield Finding(
                "warning",
                f"joint {joint}",
                f"has a torque limit of {limit:g} N m, over {TORQUE_SHARE:g} times the robot's "
                "weight at the height of its centre of mass",
                f"the motor's torque, in the robot file 'effort: {{{joint}: N m}}'",
            )


def _ranges(robot: Robot) -> Iterator[Finding]:
    model = robot.model
    for joint in robot.joint_names:
        kind = model.joints[model.getJointId(joint)]
        low, high = model.lowerPositionLimit[kind.idx_q], model.upperPositionLimit[kind.idx_q]
        if _turns(robot, joint) and not high - low <= TURN:
            yield Finding(
                "warning",
                f"joint {joint}",
                f"turns from {low:.4g} to {high:.4g} rad",
                f"its real range, in the robot file 'position: {{{joint}: [low, high]}}'",
            )


def _turns(robot: Robot, joint: str) -> bool:
    """Whether a joint is revolute; the others are prismatic."""
    kind = robot.model.joints[robot.model.getJointId(joint)].shortname()
    return not kind.removeprefix("JointModel").startswith("P")


def _twins(robot: Robot) -> Iterator[Finding]:
    """Compare joints of the left with those of the right, equal or mirrored."""
    model = robot.model

    def range_of(joint: str) -> tuple[float, float]:
        place = model.joints[model.getJointId(joint)].idx_q
        return float(model.lowerPositionLimit[place]), float(model.upperPositionLimit[place])

    for joint in robot.joint_names:
        twin = _twin_of(joint, robot.joint_names)
        if twin is None:
            continue
        (low, high), (other_low, other_high) = range_of(joint), range_of(twin)
        same = max(abs(low - other_low), abs(high - other_high))
        mirrored = max(abs(low + other_high), abs(high + other_low))
        if min(same, mirrored) > ROUNDING:
            yield Finding(
                "warning",
                f"joint {joint}",
                f"turns from {low:.4g} to {high:.4g} rad, {twin} from {other_low:.4g} to "
                f"{other_high:.4g} rad: one may have the limits of another joint",
                "the real ranges, in the robot file 'position: {joint: [low, high]}'",
            )
        efforts = [robot.torque_limit[robot.joint_names.index(each)] for each in (joint, twin)]
        if efforts[0] != efforts[1]:
            yield Finding(
                "warning",
                f"joint {joint}",
                f"has a torque limit of {efforts[0]:g} N m, {twin} of {efforts[1]:g} N m",
                "the motors' torques, in the robot file 'effort: {joint: N m}'",
            )


def _twin_of(joint: str, joints: list[str]) -> str | None:
    """Find the joint of the other side, for one of the left side."""
    for left, right in TWINS:
        for part in re.finditer(
            rf"(?i)(?<![a-z]){left}(?![a-z])|(?<![a-z]){left}(?=[A-Z_])", joint
        ):
            found = part.group()
            swapped = right.upper() if found.isupper() else right
            swapped = (
                swapped.capitalize() if found[:1].isupper() and found[1:].islower() else swapped
            )
            twin = joint[: part.start()] + swapped + joint[part.end() :]
            if twin in joints:
                return twin
    return None
