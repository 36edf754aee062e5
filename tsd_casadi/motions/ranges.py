"""What a robot can do of a motion: the range of each of its parameters.

The robot file may narrow a range; otherwise it is what inverse kinematics
reaches inside the joints' limits, over a whole lap.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cache

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.motion import Motion, declared_parameters
from tsd_casadi.motions.parameter import Parameter
from tsd_casadi.robot.reaching import reach
from tsd_casadi.robot.robot import Robot

# phases at which a lap's posture has to be reachable
PHASES = 8
# a motion this large is out of every robot's reach [m, rad]
LARGEST_EXTENT = 3.0
# the range's upper end is found to this share of itself
RESOLUTION = 0.02
# frequencies where the file says nothing [Hz]: slower is standing, faster leaves the ground
FREQUENCIES = (0.05, 1.0)


def range_of(robot: Robot, kind: type[Motion], item: Parameter) -> tuple[float, float]:
    """Find the range of a parameter on a robot, the other parameters at their defaults.

    Args:
        kind: The motion's class.
        item: One of its parameters.

    Returns:
        (low, high), SI units.
    """
    part = robot.description.motions.get(kind.name)
    if part is not None and item.name in part.ranges:
        return part.ranges[item.name]
    if item.name == "frequency":
        return max(item.low, FREQUENCIES[0]), min(item.high, FREQUENCIES[1])
    if item.extent:
        return item.low, _largest_extent(robot, kind, item.name)
    return item.low, item.high


def check_motion(robot: Robot, motion: Motion) -> None:
    """Refuse what a robot cannot do.

    Raises:
        InvalidValue: If a parameter is out of the robot's range; it names the
            ones among a tenth, a hundredth and a thousandth that are not.
    """
    for item in declared_parameters(type(motion)):
        low, high = range_of(robot, type(motion), item)
        value = motion.parameters[item.name]
        if low <= value <= high and math.isfinite(value):
            continue
        expected = f"{low:g} to {high:g} {item.unit} for {robot.name}"
        nearby = [value / ten for ten in (10, 100, 1000) if low <= value / ten <= high]
        if item.extent and nearby:
            expected += f"; did you mean {' or '.join(f'{x:g}' for x in nearby)} {item.unit}?"
        raise InvalidValue(item.name, f"{value:g}", expected)


@cache
def _largest_extent(robot: Robot, kind: type[Motion], name: str) -> float:
    """Find the largest value of a parameter at which a whole lap can be reached."""
    low, high = 0.0, LARGEST_EXTENT
    while high - low > RESOLUTION * max(high, 1e-3):
        middle = 0.5 * (low + high)
        if _reaches(robot, kind, name, middle):
            low = middle
        else:
            high = middle
    return low


def _reaches(robot: Robot, kind: type[Motion], name: str, value: float) -> bool:
    given = {
        item.name: item.default if item.default is not None else value
        for item in declared_parameters(kind)
    }
    motion = dataclasses.replace(kind(**given), **{name: value})  # type: ignore[type-var]
    axes = motion.axes(robot)
    middle = motion.middle(robot)
    for index in range(PHASES):
        offset = motion.offset(2 * math.pi * index / PHASES)
        if reach(robot, middle, dict(zip(axes, map(float, offset.x), strict=True))) is None:
            return False
    return True
