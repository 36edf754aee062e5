"""Entries read from rows of the tables: whole, without weights, or with those that are served."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from tsd_casadi.database.damaged_entry import DamagedEntry
from tsd_casadi.database.database_file import DatabaseFile
from tsd_casadi.database.entry_index import IndexedEntry
from tsd_casadi.database.iteration_rows import IterationOutline, IterationRow
from tsd_casadi.database.kept_entries import KeptEntries
from tsd_casadi.database.rows import EntryRow, EventRow, build
from tsd_casadi.exceptions import MalformedMessage
from tsd_casadi.learning.entry import Entry
from tsd_casadi.motions.declaration import Declaration

COLUMNS = {
    "entry": (*EntryRow.model_fields, "checksum"),
    "event": (*EventRow.model_fields, "checksum"),
    "iteration": (*IterationRow.model_fields, "checksum"),
}
_NOT_FORGOTTEN = "id NOT IN (SELECT entry FROM event WHERE kind = 'forgotten')"
# the newest row of each iteration
_NEWEST = (
    "entry = ? AND event = (SELECT max(event) FROM iteration AS other "
    "WHERE other.entry = iteration.entry AND other.number = iteration.number) ORDER BY number"
)

Columns = dict[str, Any]
Read = tuple[list[Entry], list[DamagedEntry]]


class EntryRows:
    """Reads entries; the caller begins and ends the transactions."""

    def __init__(self, file: DatabaseFile, kept: KeptEntries) -> None:
        """Take an open file.

        Args:
            kept: What was decoded before.
        """
        self._file = file
        self._kept = kept

    def read(self, robot: str | None = None, motion: str | None = None) -> Read:
        """Read entries, in the order of their identifiers, and which are damaged.

        Args:
            robot: Only of this robot.
            motion: Only of this motion.
        """
        rows = select(
            self._file,
            "entry",
            f"(? IS NULL OR robot = ?) AND (? IS NULL OR motion = ?) AND {_NOT_FORGOTTEN} "
            "ORDER BY id",
            (robot, robot, motion, motion),
        )
        return self._built(rows, IterationRow)

    def outlines(self, identifiers: Sequence[int]) -> Read:
        """Read entries of some numbers without their weights; the rest as above."""
        return self._built(
            (row for each in identifiers for row in select(self._file, "entry", "id = ?", (each,))),
            IterationOutline,
        )

    def entry(self, identifier: int) -> Entry | DamagedEntry:
        """Read one entry anew, or say why it cannot be."""
        rows = select(self._file, "entry", "id = ?", (identifier,))
        try:
            if not rows:
                raise MalformedMessage("no row of it", "one")
            return self._build(rows[0], self.iterations(identifier), IterationRow)
        except ValueError as error:  # of pydantic, or one of ours for shapes and rules
            return self._damaged(identifier, error)

    def served(self, indexed: IndexedEntry) -> Entry | DamagedEntry:
        """Read an entry with the weights that it serves and no others, or take the one kept.

        Args:
            indexed: As the index knows it.

        Returns:
            The entry, not to be changed.
        """
        identifier = indexed.identifier
        kept = self._kept.find(identifier, indexed.event)
        if kept is not None:
            return kept
        try:
            rows = select(self._file, "entry", "id = ?", (identifier,))
            iterations = self.iterations(identifier)
            entry = self._build(rows[0], iterations, IterationOutline)
            if entry.key != indexed.key:
                raise MalformedMessage(
                    f"an index that has it as {indexed.key.describe()}", "it as its rows say"
                )
            served = entry.served
            # and the one that it was learned from, which says how large it may be
            wanted = (served.number, served.learned_from)
            for place, each in enumerate(entry.iterations):
                if each.number in wanted:
                    row = IterationRow.of_checked(iterations[place])
                    entry.iterations[place] = row.iteration(entry.key.axes, entry.basis.L)
        except (ValueError, IndexError) as error:
            return self._damaged(identifier, error)
        self._kept.keep(indexed.event, entry)
        return entry

    def declaration(self, event: int) -> Declaration | None:
        """Read what an event said of a motion; None if it is damaged."""
        for row in select(self._file, "event", "id = ?", (event,)):
            try:
                return EventRow.check(row).declaration
            except ValueError:  # the entry says so when it is read
                return None
        return None

    def exists(self, identifier: int) -> bool:
        """Say whether there is an entry of that number, readable or not."""
        return bool(select(self._file, "entry", f"id = ? AND {_NOT_FORGOTTEN}", (identifier,)))

    def iterations(self, identifier: int) -> list[Columns]:
        """Read the newest row of each iteration of an entry."""
        return select(self._file, "iteration", _NEWEST, (identifier,))

    def _built(self, rows: Iterable[Columns], kind: type[IterationOutline]) -> Read:
        entries, damaged = [], []
        for row in rows:
            try:
                entries.append(self._build(row, self.iterations(row["id"]), kind))
            except ValueError as error:
                damaged.append(self._damaged(row["id"], error))
        return entries, damaged

    def _build(
        self, row: Columns, iterations: Sequence[Columns], kind: type[IterationOutline]
    ) -> Entry:
        events = select(self._file, "event", "entry = ? ORDER BY id", (row["id"],))
        return build(
            EntryRow.check(row),
            [EventRow.check(each) for each in events],
            [kind.check(each) for each in iterations],
        )

    def _damaged(self, identifier: int, error: Exception) -> DamagedEntry:
        damaged = DamagedEntry.of(identifier, error)
        self._kept.note(damaged)
        return damaged


def select(
    file: DatabaseFile, table: str, condition: str, values: Sequence[Any] = ()
) -> list[Columns]:
    """Read rows of a table with all their columns.

    Args:
        condition: SQL after WHERE, with a placeholder for each value.
        values: Of the placeholders.
    """
    names = COLUMNS[table]
    rows = file.execute(f"SELECT {', '.join(names)} FROM {table} WHERE {condition}", tuple(values))
    return [dict(zip(names, row, strict=True)) for row in rows]
