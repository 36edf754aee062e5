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
        matched = [pattern] if pattern in joints else _match(robot_file, field, pattern, joints)
        if not matched:
            raise RobotFileError(
                robot_file,
                f"{field}.{pattern}",
                "matches no joint of the description",
                f"the name of a joint or a regular expression for some, {nearest(pattern, joints)}",
            )
        found.update(dict.fromkeys(matched, value))
    return {joint: found[joint] for joint in joints if joint in found}


def _match(robot_file: Path, field: str, pattern: str, joints: Sequence[str]) -> list[str]:
    try:
        expression = re.compile(pattern)
    except re.error as error:
        raise RobotFileError(
            robot_file,
            f"{field}.{pattern}",
            f"is no regular expression ({error})",
            "the name of a joint, or a pattern such as .*_hand_.*",
        ) from error
    return [joint for joint in joints if expression.fullmatch(joint)]
