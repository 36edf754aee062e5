"""The parameters that tell repetitions of one task from another, with units.

One table for the database, the messages and the learner service. A motion that
is not in it, of somebody's own, may be learned all the same: its parameters are
taken as they come, without unit, default or range.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tsd_casadi.exceptions import InvalidValue

# of any parameter, in its SI unit
LARGEST = 1e6
# words of queries and of the database that a parameter cannot have for a name
RESERVED = ("task", "robot", "kind", "extrapolate", "region")


@dataclass(frozen=True)
class TaskParameter:
    """One parameter of a task.

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
        """For people: 'height [m], default 0'."""
        default = "" if self.default is None else f", default {self.default:g}"
        return f"{self.name} [{self.unit}]{default}"


TASK_PARAMETERS: dict[str, tuple[TaskParameter, ...]] = {
    "squat": (
        TaskParameter("amplitude", "m"),
        TaskParameter("frequency", "Hz"),
        TaskParameter("height", "m", default=0.0, positive=False),
    ),
}


def unit_of(task: str, name: str) -> str:
    """Unit of a parameter; empty for a task of somebody's own.

    Args:
        task: Name of the motion.
        name: Name of the parameter.
    """
    units = {known.name: known.unit for known in TASK_PARAMETERS.get(task, ())}
    return units.get(name, "")


def default_parameters(task: str) -> dict[str, float]:
    """The parameters that need not be said, with what they are then.

    Args:
        task: Name of the motion.
    """
    known = TASK_PARAMETERS.get(task, ())
    return {item.name: item.default for item in known if item.default is not None}


def complete_parameters(task: str, given: Mapping[str, float]) -> dict[str, float]:
    """All parameters of a task, checked, those with a default filled in.

    Args:
        task: Name of the motion.
        given: Parameters by name, SI units.

    Raises:
        InvalidValue: If one is missing, unknown, not finite or not positive.
    """
    known = {item.name: item for item in TASK_PARAMETERS.get(task, ())}
    for name, value in given.items():
        if name in RESERVED:
            raise InvalidValue(f"parameter '{name}'", f"{value:g}", "another name")
        if known and name not in known:
            raise InvalidValue(f"parameter of the {task}", f"'{name}'", _listed(task))
        unit = f" in {known[name].unit}" if known else ""
        if not abs(value) < LARGEST:
            raise InvalidValue(name, value, f"a number{unit} below {LARGEST:g}")
        if known and known[name].positive and value <= 0:
            raise InvalidValue(name, value, f"a positive number{unit}")
    complete = {**default_parameters(task), **given}
    missing = [name for name in known if name not in complete]
    if missing:
        raise InvalidValue(
            f"the {task}", f"without {' and without '.join(missing)}", f"all of {_listed(task)}"
        )
    return complete


def _listed(task: str) -> str:
    return "; ".join(item.describe() for item in TASK_PARAMETERS[task])
