"""The fields of a request that say what joints must not exceed."""

from __future__ import annotations

import numpy as np

from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector
from tsd_casadi.tick.layout import HUGE, Field

# of control and simulation loops, with a wide berth [s]
PERIOD = 1e-3
SHORTEST_PERIOD, LONGEST_PERIOD = 1e-5, 0.1
# without braking nothing could move that is bounded by its position [rad/s^2]
LEAST_BRAKING = 1e-3
# slower than any motor, faster than nothing: speeds are divided by it [rad/s]
LEAST_SPEED = 1e-3


def limit_fields(robot: Robot) -> tuple[Field, ...]:
    """Lay out limits of torque, acceleration, velocity and position.

    Returns:
        Fields limits.*, with the defaults of the robot.
    """
    n = robot.n
    return (
        Field(
            "limits.torque",
            n,
            "N m",
            "bound of |tau|",
            lower=0.0,
            default=tuple(robot.torque_limit),
        ),
        Field(
            "limits.stall_torque",
            n,
            "N m",
            "torque of a motor's line of torque over speed at rest; 1e9 where it is unknown",
            lower=0.0,
            default=_known(robot.stall_torque),
        ),
        Field(
            "limits.no_load_speed",
            n,
            "rad/s",
            "speed at which that line is at zero: from there on no torque drives the joint; 1e9 "
            "where it is unknown",
            lower=LEAST_SPEED,
            default=_known(robot.no_load_speed),
        ),
        Field(
            "limits.acceleration",
            n,
            "rad/s^2",
            "bound of |qdd| of the joints",
            lower=0.0,
            default=tuple(robot.acceleration_limit),
        ),
        Field(
            "limits.velocity",
            n,
            "rad/s",
            "bound of |v| of the joints one period later; 1e9 where it is unknown",
            lower=0.0,
            default=_known(robot.velocity_limit),
        ),
        Field(
            "limits.position_lower",
            n,
            "rad",
            "least angles of the joints",
            default=_known(robot.position_limits[0]),
        ),
        Field(
            "limits.position_upper",
            n,
            "rad",
            "largest angles of the joints",
            default=_known(robot.position_limits[1]),
        ),
        Field(
            "limits.braking",
            n,
            "rad/s^2",
            "acceleration that a joint counts on to stop before its position's limit; the "
            "acceleration limit where that is smaller",
            lower=LEAST_BRAKING,
            default=tuple(robot.braking),
        ),
        Field(
            "limits.velocity_active",
            1,
            "1",
            "whether velocities are bounded",
            lower=0.0,
            upper=1.0,
            default=(1.0,),
            switch=True,
        ),
        Field(
            "limits.position_active",
            1,
            "1",
            "whether positions are bounded",
            lower=0.0,
            upper=1.0,
            default=(1.0,),
            switch=True,
        ),
        Field(
            "period",
            1,
            "s",
            "from this tick to the next: for what the limits of velocity and position predict",
            lower=SHORTEST_PERIOD,
            upper=LONGEST_PERIOD,
            default=(PERIOD,),
        ),
    )


def _known(limits: Vector) -> tuple[float, ...]:
    return tuple(np.clip(limits, -HUGE, HUGE))
