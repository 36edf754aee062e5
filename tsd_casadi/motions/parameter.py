"""The parameters that tell one variation of a motion from another, with units.

One table for the database, the messages and the learner service. A motion that
is not in it, of somebody's own, may be learned all the same: its parameters are
taken as they come, without unit, default or range.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.exceptions.did_you_mean import did_you_mean

# of any parameter, in its SI unit
LARGEST = 1e6
# words of queries and of the database that a parameter cannot have for a name
RESERVED = ("task", "robot", "kind", "extrapolate", "region")


@dataclass(frozen=True)
class Parameter:
    """One parameter of a motion.

    Attributes:
        name: Its name.
        unit: SI unit.
        default: What it is where nothing is said; None if it has to be said.
        positive: Whether zero and negative values make no sense.
    """

    name: str
    unit: str
    default: float | None = None
    positive: bool = True

    def describe(self) -> str:
        """Tell people: 'height [m], default 0'."""
        default = "" if self.default is None else f", default {self.default:g}"
        return f"{self.name} [{self.unit}]{default}"


MOTION_PARAMETERS: dict[str, tuple[Parameter, ...]] = {
    "squat": (
        Parameter("amplitude", "m"),
        Parameter("frequency", "Hz"),
        Parameter("height", "m", default=0.0, positive=False),
    ),
}


def unit_of(motion: str, name: str) -> str:
    """Find the unit of a parameter; empty for a motion of somebody's own."""
    units = {known.name: known.unit for known in MOTION_PARAMETERS.get(motion, ())}
    return units.get(name, "")


def default_parameters(motion: str) -> dict[str, float]:
    """List the parameters that need not be said, with what they are then."""
    known = MOTION_PARAMETERS.get(motion, ())
    return {item.name: item.default for item in known if item.default is not None}


def complete_parameters(motion: str, given: Mapping[str, float]) -> dict[str, float]:
    """Check the parameters of a motion and fill in those with a default.

    Args:
        given: By name, SI units.

    Raises:
        InvalidValue: If one is missing, unknown, not finite or not positive.
    """
    known = {item.name: item for item in MOTION_PARAMETERS.get(motion, ())}
    for name, value in given.items():
        if name in RESERVED:
            raise InvalidValue(f"parameter '{name}'", f"{value:g}", "another name")
        if known and name not in known:
            expected = _listed(motion) + did_you_mean(name, known)
            raise InvalidValue(f"parameter of the {motion}", f"'{name}'", expected)
        unit = f" in {known[name].unit}" if known else ""
        if not abs(value) < LARGEST:
            raise InvalidValue(name, value, f"a number{unit} below {LARGEST:g}")
        if known and known[name].positive and value <= 0:
            raise InvalidValue(name, value, f"a positive number{unit}")
    complete = {**default_parameters(motion), **given}
    missing = [name for name in known if name not in complete]
    if missing:
        raise InvalidValue(
            f"the {motion}", f"without {' and without '.join(missing)}", f"all of {_listed(motion)}"
        )
    return complete


def _listed(motion: str) -> str:
    return "; ".join(item.describe() for item in MOTION_PARAMETERS[motion])
