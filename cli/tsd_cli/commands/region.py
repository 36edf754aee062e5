"""Regions of task parameters in words of the command line."""

from __future__ import annotations

from collections.abc import Sequence

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.robot.robot import Robot

EXPECTED = "NAME=LOW:HIGH, as amplitude=0.02:0.08, or NAME alone for the robot's whole range"


def parse_region(texts: Sequence[str], robot: Robot) -> dict[str, tuple[float, float]]:
    """The ranges in which squats may be chosen.

    Args:
        texts: 'amplitude=0.02:0.08', or 'amplitude' for the range in the robot
            file; one for each parameter.
        robot: The robot.

    Returns:
        (low, high) by name, SI units.

    Raises:
        InvalidValue: If one cannot be read, or leaves the robot's range.
    """
    ranges = robot.description.motions.squat
    possible = {
        "amplitude": ranges.amplitude,
        "frequency": ranges.frequency,
        "height": ranges.height,
    }
    region = {}
    for text in texts:
        name, given, ends = text.partition("=")
        if name not in possible or name in region:
            raise InvalidValue("the region", repr(text), f"{EXPECTED}; each name once")
        lowest, highest = possible[name]
        low, high = _numbers(text, ends) if given else (lowest, highest)
        if not lowest <= low < high <= highest:
            raise InvalidValue(
                f"the region of {name}",
                f"{low:g}:{high:g}",
                f"low before high, within {lowest:g}:{highest:g} for {robot.name}",
            )
        region[name] = low, high
    return region


def _numbers(text: str, ends: str) -> tuple[float, float]:
    low, _, high = ends.partition(":")
    try:
        return float(low), float(high)
    except ValueError:
        raise InvalidValue("the region", repr(text), EXPECTED) from None
