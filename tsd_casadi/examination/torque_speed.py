"""What motors have left as they turn faster, where the robot file says so."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tsd_casadi.examination.finding import Finding
from tsd_casadi.robot.robot import Robot


@dataclass(frozen=True)
class TorqueSpeedLine:
    """The line of one joint, with the limits that are there beside it.

    Attributes:
        joint: Its name.
        torque_limit: [N m].
        stall_torque: The line's torque at rest [N m].
        no_load_speed: Where the line is at zero [rad/s].
        full_torque_speed: Up to where the torque limit counts [rad/s].
        velocity_limit: [rad/s], None where there is none.
    """

    joint: str
    torque_limit: float
    stall_torque: float
    no_load_speed: float
    full_torque_speed: float
    velocity_limit: float | None


def torque_speed_lines(robot: Robot) -> tuple[TorqueSpeedLine, ...]:
    """List the joints for which the robot file has a line."""
    lines = []
    for index in np.flatnonzero(np.isfinite(robot.no_load_speed)):
        limit, stall = float(robot.torque_limit[index]), float(robot.stall_torque[index])
        no_load, velocity = float(robot.no_load_speed[index]), float(robot.velocity_limit[index])
        lines.append(
            TorqueSpeedLine(
                robot.joint_names[index],
                limit,
                stall,
                no_load,
                no_load * max(0.0, 1.0 - limit / stall),
                velocity if np.isfinite(velocity) else None,
            )
        )
    return tuple(lines)


def unreachable_speeds(lines: Sequence[TorqueSpeedLine]) -> Iterator[Finding]:
    """Look for velocity limits that no motor gets to."""
    for line in lines:
        if line.velocity_limit is not None and line.velocity_limit > line.no_load_speed:
            yield Finding(
                "warning",
                f"joint {line.joint}",
                f"may turn at {line.velocity_limit:g} rad/s, its motor has no torque left from "
                f"{line.no_load_speed:g} on",
                f"'velocity: {{{line.joint}: {line.no_load_speed:g}}}' in the robot file, or the "
                "motor's 'torque_speed'",
            )
