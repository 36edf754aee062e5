"""How a database file is, told without reading an entry."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DatabaseState:
    """How a database file is.

    Attributes:
        path: The file.
        schema_version: Of its tables.
        entries: Number of entries.
        damaged: Number of entries that could not be read since it was opened;
            ``Database.verify`` looks for all.
        size: Of the file and of what is not yet merged into it [bytes].
        last_write: When something was added last, ISO 8601, UTC; None if nothing was.
    """

    path: str
    schema_version: int
    entries: int
    damaged: int
    size: int
    last_write: str | None
