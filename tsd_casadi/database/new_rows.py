"""Rows that are added when something happens to an entry."""

from __future__ import annotations

from typing import Any

from tsd_casadi.database.checksum import with_checksum
from tsd_casadi.database.columns import entry_columns, event_columns, iteration_columns
from tsd_casadi.database.database_file import DatabaseFile
from tsd_casadi.database.entry_rows import EntryRows
from tsd_casadi.database.rows import EventKind
from tsd_casadi.learning.entry import Entry


class NewRows:
    """Adds to the tables; the caller begins and ends the transactions."""

    def __init__(self, file: DatabaseFile, rows: EntryRows) -> None:
        """Take an open file, and what reads it."""
        self._file = file
        self._rows = rows

    def add(self, entry: Entry, kind: EventKind) -> None:
        """Add what is new of an entry; a new one gets its identifier.

        Args:
            kind: What happened to it.
        """
        event = self._next("event")
        if not entry.identifier:
            entry.identifier = self._next("entry")
            self._insert("entry", entry_columns(entry))
        self._insert("event", event_columns(entry, event, kind))
        if kind == "recorded":
            entry.sequence = event
        known = {row["number"]: row for row in self._rows.iterations(entry.identifier)}
        for iteration in entry.iterations:
            columns = iteration_columns(entry.identifier, event, iteration)
            before = known.get(iteration.number)
            if before is None or any(
                before[name] != value for name, value in columns.items() if name != "event"
            ):
                self._insert("iteration", columns)

    def forget(self, identifier: int, time: str) -> None:
        """Note that an entry counts no more, damaged or not."""
        self._insert(
            "event",
            {
                "id": self._next("event"),
                "entry": identifier,
                "kind": "forgotten",
                "time": time,
                "body": "",
                "formulation": "",
                "correction": "",
                "declaration": None,
                "circumstances": '{"gains": {}}',
                "rule": "plain",
                "learning_gain": 1.0,
            },
        )

    def _insert(self, table: str, columns: dict[str, Any]) -> None:
        row = with_checksum(columns)
        self._file.execute(
            f"INSERT INTO {table} ({', '.join(row)}) VALUES ({', '.join('?' for _ in row)})",
            tuple(row.values()),
        )

    def _next(self, table: str) -> int:
        return int(self._file.execute(f"SELECT coalesce(max(id), 0) + 1 FROM {table}")[0][0])
