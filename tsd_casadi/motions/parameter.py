"""What tells one variation of a motion from another: parameters with unit, default and range."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

# of any parameter, in its SI unit
LARGEST = 1e6
# words of queries and of the database that a parameter cannot have for a name
RESERVED = (
    "motion",
    "task",
    "robot",
    "kind",
    "extrapolate",
    "region",
    "axes",
    "body",
    "formulation",
    "correction",
    "version",
    "forget",
)


@dataclass(frozen=True)
class Parameter:
    """One parameter of a motion.

    Attributes:
        name: Its name.
        unit: SI unit.
        meaning: What it is, a few words for help and docs.
        default: What it is where nothing is said; None if it has to be said.
        low: Smallest value that makes sense on any robot.
        high: Largest value that makes sense on any robot.
        extent: Whether it says how far the motion goes: its range is what the
            robot can reach, where its file does not narrow it.
        place: Whether it says where the middle of the motion is: its range is
            where the robot can stand, where its file does not narrow it.
        usual: What a command that moves the robot takes where nothing is said and
            there is no default; None if it has to be said there too.
    """

    name: str
    unit: str
    meaning: str = ""
    default: float | None = None
    low: float = -LARGEST
    high: float = LARGEST
    extent: bool = False
    place: bool = False
    usual: float | None = None

    def describe(self) -> str:
        """For people: 'height [m], default 0'."""
        default = "" if self.default is None else f", default {self.default:g}"
        return f"{self.name} [{self.unit}]{default}"

    def range_text(self) -> str:
        """For people, what makes sense on any robot: 'at least 0 m'."""
        if self.high >= LARGEST:
            return f"at least {self.low:g} {self.unit}".rstrip()
        return f"{self.low:g} to {self.high:g} {self.unit}".rstrip()


def parameter(
    unit: str,
    meaning: str = "",
    *,
    default: float | None = None,
    low: float = -LARGEST,
    high: float = LARGEST,
    extent: bool = False,
    place: bool = False,
    usual: float | None = None,
) -> Any:
    """Declare a field of a motion's class as one of its parameters; see ``Parameter``."""
    declared = Parameter("", unit, meaning, default, low, high, extent, place, usual)
    value = dataclasses.MISSING if default is None else default
    return dataclasses.field(default=value, metadata={"parameter": declared})
