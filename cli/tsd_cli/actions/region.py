"""Regions of a motion's parameters in words of the command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.exceptions.did_you_mean import did_you_mean
from tsd_casadi.motions.motion import Motion, declared_parameters
from tsd_casadi.motions.ranges import range_of
from tsd_casadi.robot.robot import Robot

EXPECTED = "NAME=LOW:HIGH, as {example}=0.02:0.08, or NAME alone"

Ends = tuple[float, float]


def read_region(texts: Sequence[str], robot: Robot, kind: type[Motion]) -> dict[str, Ends]:
    """Read the ranges in which motions may be chosen.

    Args:
        texts: 'amplitude=0.02:0.08', or 'amplitude' for ``default_ends``; one for
            each parameter.
        kind: The motion's class.

    Returns:
        (low, high) by name, SI units.

    Raises:
        InvalidValue: If one cannot be read, or leaves the robot's range.
    """
    possible = {item.name: item for item in declared_parameters(kind)}
    expected = EXPECTED.format(example=next(iter(possible)))
    region: dict[str, Ends] = {}
    for text in texts:
        name, given, ends = text.partition("=")
        if name not in possible:
            raise InvalidValue(
                "the region",
                repr(text),
                f"{expected}, with one of {', '.join(possible)}{did_you_mean(name, possible)}",
            )
        if name in region:
            raise InvalidValue("the region", repr(text), f"{expected}; each name once")
        lowest, highest = range_of(robot, kind, possible[name])
        low, high = _numbers(text, ends, expected) if given else default_ends(lowest, highest)
        if not lowest <= low < high <= highest:
            raise InvalidValue(
                f"the region of {name}",
                f"{low:g}:{high:g}",
                f"low before high, within {lowest:g}:{highest:g} for {robot.name}",
            )
        region[name] = low, high
    return region


def default_name(kind: type[Motion]) -> str:
    """Choose what is varied where nobody says: how far the motion goes."""
    items = declared_parameters(kind)
    return next((item.name for item in items if item.extent), items[0].name)


def default_ends(lowest: float, highest: float) -> Ends:
    """Choose a range where none was given: what is worth learning of a robot's range.

    Sizes are taken from a quarter of the largest on: what is needed for smaller
    ones is small itself, and a squat of a millimetre teaches nothing. Where zero
    lies inside, a parameter is a place rather than a size and all of it counts.
    """
    if lowest < 0 < highest:
        return lowest, highest
    return max(lowest, highest / 4), highest


def describe_chosen(
    texts: Sequence[str], region: Mapping[str, Ends], kind: type[Motion]
) -> list[str]:
    """Say what was chosen for names without a range, a line each.

    Args:
        texts: As given by the user.
        region: As read from them.
        kind: The motion's class.
    """
    declaration = kind.declaration()
    lines = []
    for name in (text for text in texts if "=" not in text):
        low, high = region[name]
        unit = declaration.unit_of(name)
        lines.append(
            f"region of {name}: {low:g} to {high:g} {unit}; --region {name}=LOW:HIGH for another"
        )
    return lines


def _numbers(text: str, ends: str, expected: str) -> Ends:
    low, _, high = ends.partition(":")
    try:
        return float(low), float(high)
    except ValueError:
        raise InvalidValue("the region", repr(text), expected) from None
