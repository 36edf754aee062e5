"""What is said about one tick: why its QP has no solution, or what its limits cost."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from tsd_casadi.explanation.conflict_sentence import tell_conflict
from tsd_casadi.explanation.row_words import describe_row


@dataclass(frozen=True)
class ConflictingRow:
    """A limit that cannot hold together with the others of its set.

    Attributes:
        name: Of the row.
        side: 'upper' or 'lower'.
        bound: What it may not pass, in its unit.
        violation: By how much it is violated if all rows of the set give way, each by
            the same share of what it would need alone.
        alone: By how much it would have to give way alone.
    """

    name: str
    side: str
    bound: float
    violation: float
    alone: float

    def plain(self) -> dict[str, Any]:
        """Write it as plain data, with its words and unit."""
        return {**asdict(self), **asdict(describe_row(self.name))}


@dataclass(frozen=True)
class LimitCost:
    """An active limit and what it costs the tasks.

    Attributes:
        name: Of the row.
        side: 'upper' or 'lower'.
        bound: What it does not pass, in its unit.
        multiplier: Change of the QP's cost per unit of the row.
        tasks: Acceleration that is missing because of it, by axis [m/s^2, rad/s^2].
    """

    name: str
    side: str
    bound: float
    multiplier: float
    tasks: dict[str, float]

    def plain(self) -> dict[str, Any]:
        """Write it as plain data, with its words and unit."""
        return {**asdict(self), **asdict(describe_row(self.name))}


@dataclass(frozen=True)
class Explanation:
    """Of one tick.

    Attributes:
        feasible: Whether dynamics, contacts and limits can hold together.
        dependent: How many of the contacts' rows follow from others and are not held, or
            in part.
        conflict: Where limits contradict each other: an irreducible set, limits of
            accelerations last.
        limits: Where they do not: the active ones, the costliest first.
        otherwise: Acceleration that tasks miss without any limit, by axis: given up to
            other tasks and the posture.
    """

    feasible: bool
    dependent: int = 0
    conflict: tuple[ConflictingRow, ...] = ()
    limits: tuple[LimitCost, ...] = ()
    otherwise: dict[str, float] | None = None

    def sentence(self) -> str:
        """Say it in one sentence, for a message."""
        if self.conflict:
            return tell_conflict({row.name: row.alone for row in self.conflict})
        return "all limits can hold together"

    def plain(self) -> dict[str, Any]:
        """Write it as plain data for JSON."""
        return {
            "feasible": self.feasible,
            "dependent": self.dependent,
            "conflict": [row.plain() for row in self.conflict],
            "limits": [limit.plain() for limit in self.limits],
            "otherwise": self.otherwise,
        }
