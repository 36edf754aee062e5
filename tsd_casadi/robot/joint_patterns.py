"""Joints that a robot file names, or matches by a regular expression."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TypeVar

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.exceptions.did_you_mean import nearest

Value = TypeVar("Value")


def values_by_joint(
    robot_file: Path, field: str, patterns: Mapping[str, Value], joints: Sequence[str]
) -> dict[str, Value]:
    """Find what a section of the robot file says of each joint.

    Args:
        field: The section's name, for errors.
        patterns: Value by name or by regular expression, which has to match a
            whole name; the last that matches counts.

    Returns:
        Value by joint, in the joints' order, for those that are matched.

    Raises:
        RobotFileError: If one is no regular expression or matches no joint.
    """
    found: dict[str, Value] = {}
    for pattern, value in patterns.items():
        found.update(
            dict.fromkeys(matching_joints(robot_file, f"{field}.{pattern}", pattern, joints), value)
        )
    return {joint: found[joint] for joint in joints if joint in found}


def matching_joints(path: Path, field: str, pattern: str, joints: Sequence[str]) -> list[str]:
    """Find the joints that a name or a regular expression means.

    Args:
        path: Of the file that is to blame if there are none.
        field: What is to blame in it.
        pattern: A joint's name, or an expression that has to match a whole name.

    Raises:
        RobotFileError: If it is no regular expression or matches no joint.
    """
    if pattern in joints:
        return [pattern]
    try:
        expression = re.compile(pattern)
    except re.error as error:
        raise RobotFileError(
            path,
            field,
            f"is no regular expression ({error})",
            "the name of a joint, or a pattern for whole names such as '.*_hand_.*'",
        ) from error
    matched = [joint for joint in joints if expression.fullmatch(joint)]
    if not matched:
        raise RobotFileError(
            path,
            field,
            "matches no joint that moves",
            "the name of a joint, or a pattern for whole names such as '.*_hand_.*', "
            f"{nearest(pattern, joints)}",
        )
    return matched
