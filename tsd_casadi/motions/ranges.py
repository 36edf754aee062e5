"""What a robot can do of a motion: the range of each of its parameters.

The robot file may narrow a range; otherwise it is what inverse kinematics
reaches inside the joints' limits, over a whole lap, with the centre of mass over
the soles.
"""

from __future__ import annotations

import math
from functools import cache, lru_cache

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.described import check_described
from tsd_casadi.motions.likely_meant import likely_meant
from tsd_casadi.motions.motion import Motion, declared_parameters
from tsd_casadi.motions.parameter import Parameter
from tsd_casadi.robot.reaching import reach
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.support_polygon import margin, support_polygon

# phases at which a lap's posture has to be reachable
PHASES = 8
# a motion this large is out of every robot's reach [m, rad]
LARGEST_EXTENT = 3.0
# the range's end is found to this share of itself
RESOLUTION = 0.02
# of what can be reached standing still: at a quarter of a hertz the centre of pressure
# of an adult swings 1.2 times as far as the centre of mass (1 + omega^2 z / g), and what
# the model gets wrong and the torques needed at a joint's end want their share as well
SAFE_SHARE = 0.75
# frequencies where the file says nothing [Hz]: slower is standing, faster leaves the ground
FREQUENCIES = (0.05, 1.0)


def range_of(robot: Robot, kind: type[Motion], item: Parameter) -> tuple[float, float]:
    """Find the range of a parameter on a robot, the other parameters at their defaults.

    Args:
        kind: The motion's class.
        item: One of its parameters.

    Returns:
        (low, high), SI units, digits that people read.

    Raises:
        InvalidValue: If the robot has no task that carries the motion.
    """
    part = robot.description.motions.get(kind.name)
    if part is not None and item.name in part.ranges:
        return part.ranges[item.name]
    if item.name == "frequency":
        return max(item.low, FREQUENCIES[0]), min(item.high, FREQUENCIES[1])
    if not item.extent and not item.place:
        return item.low, item.high
    high = min(item.high, _farthest(robot, kind, item.name, 1.0))
    if item.low >= 0:
        return item.low, high
    return max(item.low, -_farthest(robot, kind, item.name, -1.0)), high


def usual_of(robot: Robot, kind: type[Motion], item: Parameter) -> float | None:
    """Find what a parameter is on a robot where nothing is said.

    Args:
        kind: The motion's class.
        item: One of its parameters.

    Returns:
        Its usual value or default, moved into the robot's range; None if it has
        neither. How far a motion goes by default is left as it is: that is the
        motion as its author wrote it, a file's references for instance.

    Raises:
        InvalidValue: If the robot has no task that carries the motion.
    """
    value = item.usual if item.default is None else item.default
    if value is None or (item.extent and item.default is not None):
        return value
    low, high = range_of(robot, kind, item)
    return min(max(value, low), high)


def check_motion(robot: Robot, motion: Motion) -> None:
    """Refuse what a robot cannot do.

    Raises:
        InvalidValue: If a parameter is out of the robot's range, or the robot has
            no task that carries the motion. A length far out of range is asked
            for in other units.
        RobotFileError: If the robot file narrows a motion or parameter that there
            is not.
    """
    check_described(robot, type(motion))
    axes = motion.axes(robot)
    tasks = {part.name: part.axes for part in robot.description.tasks}
    there = [f"{task}.{axis}" for task, its_axes in tasks.items() for axis in its_axes]
    for axis in axes:
        if axis not in there or axes.count(axis) > 1:
            raise InvalidValue(
                f"axis of {motion.name}",
                f"'{axis}'" + (" twice" if axes.count(axis) > 1 else ""),
                f"each once, of {', '.join(there)}",
            )
    for item in declared_parameters(type(motion)):
        low, high = range_of(robot, type(motion), item)
        value = motion.parameters[item.name]
        if low <= value <= high and math.isfinite(value):
            continue
        expected = f"{low:g} to {high:g} {item.unit} for {robot.name}"
        if item.unit == "m":
            expected += likely_meant(value, low, high)
        raise InvalidValue(item.name, f"{value:g}", expected)
    # ranges are those of one parameter alone; a file's are its author's word
    if motion.name not in robot.description.motions and not _reaches(robot, motion):
        together = ", ".join(f"{name} {value:g}" for name, value in motion.parameters.items())
        raise InvalidValue(
            motion.name,
            together,
            f"a lap that {robot.name} reaches inside its joints' limits with its centre of mass "
            "over its soles; each parameter is in its range, together they go too far",
        )


@cache
def _farthest(robot: Robot, kind: type[Motion], name: str, sign: float) -> float:
    """Find the largest size of a parameter at which a whole lap can be reached."""

    def can(size: float) -> bool:
        # what has no default is at rest: the place of a motion without extent, for instance
        resting = {
            item.name: min(max(0.0, item.low), item.high) if item.default is None else item.default
            for item in declared_parameters(kind)
        }
        return _reaches(robot, kind(**{**resting, name: sign * size}))

    low, high = 0.0, LARGEST_EXTENT
    while high - low > RESOLUTION * max(low, 1e-3):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if can(middle) else (low, middle)
    return _round_down(SAFE_SHARE * low)


def _round_down(value: float) -> float:
    """Keep two digits: the third says nothing about a robot."""
    if value <= 0:
        return 0.0
    digits = 1 - math.floor(math.log10(value))
    return round(math.floor(value * 10.0**digits + 1e-9) / 10.0**digits, digits)


@lru_cache(maxsize=256)
def _reaches(robot: Robot, motion: Motion) -> bool:
    axes = motion.axes(robot)
    try:
        middle = motion.middle(robot)
    except InvalidValue:
        return False
    polygon = support_polygon(robot, middle.q)
    for index in range(PHASES):
        offset = motion.offset(2 * math.pi * index / PHASES)
        posture = reach(robot, middle, dict(zip(axes, map(float, offset.x), strict=True)))
        if posture is None or margin(polygon, robot.center_of_mass(posture.q)[:2]) < 0:
            return False
    return True
