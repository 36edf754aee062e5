"""What was learned cannot be kept, found or joined."""

from __future__ import annotations

from pathlib import Path

from tsd_casadi.exceptions.base import TsdError


class LearningError(TsdError):
    """What keeps the learner from recording or answering."""


class DatabaseError(LearningError):
    """A database file cannot be used.

    Attributes:
        path: The file.
    """

    code = "database"
    path: Path | None = None

    def __init__(self, path: Path, found: str, remedy: str) -> None:
        """Create the error for one file."""
        self.path = path
        super().__init__(f"database {path}: {found}; {remedy}")


class EntryNotFound(LearningError):
    """The database has no entry for that question."""

    code = "not_found"


class OutsideTrainedRange(LearningError):
    """A query lies outside what was learned.

    Attributes:
        parameter: Name of the motion's parameter.
        value: What was asked for.
        low: Smallest learned value.
        high: Largest learned value.
    """

    code = "extrapolation"
    parameter: str | None = None
    value: float | None = None
    low: float | None = None
    high: float | None = None

    def __init__(self, parameter: str, value: float, low: float, high: float, unit: str) -> None:
        """Create the error for one parameter."""
        self.parameter = parameter
        self.value = value
        self.low = low
        self.high = high
        super().__init__(
            f"{parameter} {value:g} {unit} is outside the learned range "
            f"{low:g} to {high:g} {unit}; learn an entry beyond it, or ask with "
            "extrapolate=true"
        )


class IncompatibleEntry(LearningError):
    """A recording cannot be joined to what the database holds."""

    code = "incompatible"
