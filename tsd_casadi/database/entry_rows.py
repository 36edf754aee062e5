"""Entries as rows of the tables."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

from tsd_casadi.database.checksum import with_checksum
from tsd_casadi.database.columns import entry_columns, event_columns, iteration_columns
from tsd_casadi.database.damaged_entry import DamagedEntry
from tsd_casadi.database.database_file import DatabaseFile
from tsd_casadi.database.rows import EntryRow, EventKind, EventRow, IterationRow, build
from tsd_casadi.learning.context import NOWHERE
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey

_NOT_FORGOTTEN = "id NOT IN (SELECT entry FROM event WHERE kind = 'forgotten')"


class EntryRows:
    """Reads entries and adds to them; the caller begins and ends the transactions."""

    def __init__(self, file: DatabaseFile) -> None:
        """Take an open file."""
        self._file = file

    def read(
        self, robot: str | None = None, motion: str | None = None
    ) -> tuple[list[Entry], list[DamagedEntry]]:
        """Read entries, in the order of their identifiers, and which are damaged.

        Args:
            robot: Only of this robot.
            motion: Only of this motion.
        """
        rows = self._select(
            "entry",
            f"(? IS NULL OR robot = ?) AND (? IS NULL OR motion = ?) AND {_NOT_FORGOTTEN} "
            "ORDER BY id",
            (robot, robot, motion, motion),
        )
        entries, damaged = [], []
        for row in rows:
            try:
                entries.append(self._entry(row))
            except ValueError as error:  # of pydantic, or one of ours for shapes and rules
                reason = " ".join(str(error).split())
                damaged.append(DamagedEntry(row["id"], reason, _parameters(row)))
        return entries, damaged

    def find(self, key: EntryKey) -> Entry | None:
        """Find the entry of a key; one of unknown context where there is no other.

        Raises:
            DatabaseError: If the entry with these parameters is damaged.
        """
        entries, damaged = self.read(key.robot, key.motion)
        for wanted in (key, replace(key, context=NOWHERE)):
            for entry in entries:
                if entry.key == wanted:
                    return entry
        for each in damaged:
            if each.may_be(key.parameters):
                raise each.error(self._file.path)
        return None

    def exists(self, identifier: int) -> bool:
        """Say whether there is an entry of that number, readable or not."""
        return bool(self._select("entry", f"id = ? AND {_NOT_FORGOTTEN}", (identifier,)))

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
        known = {row["number"]: row for row in self._iterations(entry.identifier)}
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

    def _entry(self, row: Mapping[str, Any]) -> Entry:
        identifier = (row["id"],)
        events = self._select("event", "entry = ? ORDER BY id", identifier)
        iterations = self._iterations(row["id"])
        return build(
            EntryRow.check(row),
            [EventRow.check(each) for each in events],
            [IterationRow.check(each) for each in iterations],
        )

    def _iterations(self, identifier: int) -> list[dict[str, Any]]:
        """Read the newest row of each iteration."""
        return self._select(
            "iteration",
            "entry = ? AND (number, event) IN (SELECT number, max(event) FROM iteration "
            "WHERE entry = ? GROUP BY number) ORDER BY number",
            (identifier, identifier),
        )

    def _select(
        self, table: str, condition: str, values: tuple[Any, ...] = ()
    ) -> list[dict[str, Any]]:
        names = COLUMNS[table]
        rows = self._file.execute(
            f"SELECT {', '.join(names)} FROM {table} WHERE {condition}", values
        )
        return [dict(zip(names, row, strict=True)) for row in rows]

    def _insert(self, table: str, columns: dict[str, Any]) -> None:
        row = with_checksum(columns)
        self._file.execute(
            f"INSERT INTO {table} ({', '.join(row)}) VALUES ({', '.join('?' for _ in row)})",
            tuple(row.values()),
        )

    def _next(self, table: str) -> int:
        return int(self._file.execute(f"SELECT coalesce(max(id), 0) + 1 FROM {table}")[0][0])


COLUMNS = {
    "entry": (*EntryRow.model_fields, "checksum"),
    "event": (*EventRow.model_fields, "checksum"),
    "iteration": (*IterationRow.model_fields, "checksum"),
}


def _parameters(row: Mapping[str, Any]) -> tuple[tuple[str, float], ...] | None:
    with suppress(ValueError):
        checked = EntryRow.check(row)
        return EntryKey.of("", checked.motion, "", (), checked.parameters).parameters
    return None
