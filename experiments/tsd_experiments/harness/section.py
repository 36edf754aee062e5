"""What an experiment leaves for the report: claim, findings, tables, figures, goals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Goal:
    """One row of the summary.

    Attributes:
        identifier: What is compared.
        goal: Relation and bound, '>= 25', '< 5' or '90 .. 99'.
        measured: The number; None if the run does not cover it.
    """

    identifier: str
    goal: str
    measured: float | None

    @property
    def met(self) -> bool | None:
        """Whether the goal is reached; None if it was not measured."""
        if self.measured is None:
            return None
        if ".." in self.goal:
            low, high = (float(part) for part in self.goal.split(".."))
            return low <= self.measured <= high
        relation, bound = self.goal.split()
        return {
            ">=": self.measured >= float(bound),
            "<=": self.measured <= float(bound),
            "<": self.measured < float(bound),
        }[relation]

    @property
    def verdict(self) -> str:
        """Whether the goal is reached, in a word or two."""
        return {True: "met", False: "missed", None: "not covered"}[self.met]

    @property
    def measured_text(self) -> str:
        """The number for a table."""
        return "–" if self.measured is None else f"{self.measured:.4g}"

    def plain(self) -> dict[str, Any]:
        """Write the goal as plain data for JSON."""
        return {
            "id": self.identifier,
            "goal": self.goal,
            "measured": self.measured,
            "met": self.met,
        }


@dataclass(frozen=True)
class Table:
    """A table of the report.

    Attributes:
        caption: What it shows, with units.
        head: Column headings.
        rows: Cells as text.
    """

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Figure:
    """A figure of the report, drawn when it is needed.

    Attributes:
        name: Name of its files.
        caption: What it shows.
        draw: Gives a matplotlib figure.
    """

    name: str
    caption: str
    draw: Callable[[], Any]


@dataclass
class Section:
    """An experiment's part of the report.

    Attributes:
        title: Heading.
        claim: What the paper says, in our words, or what is asked here; it begins
            with whose it is.
        found: What was measured, sentences.
        tables: Tables.
        figures: Figures.
        goals: Rows of the summary.
    """

    title: str
    claim: str
    found: list[str] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    figures: list[Figure] = field(default_factory=list)
    goals: list[Goal] = field(default_factory=list)


def millimeters(value: float | None, digits: int = 3) -> str:
    """Write a length in millimetres for a table.

    Args:
        value: [m].
        digits: After the point.
    """
    return "–" if value is None else f"{1e3 * value:.{digits}f}"
