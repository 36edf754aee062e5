"""Entries as rows of the tables."""

from __future__ import annotations

import json
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

from tsd_casadi.database.database_file import DatabaseFile
from tsd_casadi.database.rows import EntryRow, IterationRow
from tsd_casadi.document import AnyDocument
from tsd_casadi.exceptions import DatabaseError
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.iteration import Iteration

# what a test leaves in its iteration, as weights
FITTED = ("feedback", "error_weights", "reference_weights")


class EntryRows:
    """Reads and writes entries; the caller begins and ends the transactions."""

    def __init__(self, file: DatabaseFile) -> None:
        """Take an open file."""
        self._file = file

    def read(self, robot: str | None = None, motion: str | None = None) -> list[Entry]:
        """Read entries, in the order of their identifiers.

        Args:
            robot: Only of this robot.
            motion: Only of this motion.

        Raises:
            DatabaseError: If one is damaged.
        """
        rows = self._file.execute(
            f"SELECT {', '.join(EntryRow.model_fields)} FROM entry "
            "WHERE (? IS NULL OR robot = ?) AND (? IS NULL OR task = ?) ORDER BY id",
            (robot, robot, motion, motion),
        )
        return [self._entry(row) for row in rows]

    def find(self, key: EntryKey) -> Entry | None:
        """Find the entry of a key, if there is one."""
        for entry in self.read(key.robot, key.motion):
            if entry.key == key:
                return entry
        return None

    def store(self, entry: Entry) -> None:
        """Write an entry with all its iterations; a new one gets its identifier."""
        entry.updated = datetime.now(UTC).isoformat(timespec="seconds")
        state = (
            json.dumps(asdict(entry.context)),
            entry.learning_gain,
            entry.rule.name,
            entry.updated,
        )
        if entry.identifier:
            self._file.execute(
                "UPDATE entry SET context = ?, learning_gain = ?, rule = ?, updated = ? "
                "WHERE id = ?",
                (*state, entry.identifier),
            )
        else:
            key = (
                entry.key.robot,
                entry.key.motion,
                json.dumps(entry.key.axes),
                json.dumps(dict(entry.key.parameters)),
                entry.basis.L,
                entry.basis.width,
            )
            rows = self._file.execute(
                "INSERT INTO entry (context, learning_gain, rule, updated, robot, task, axes, "
                "parameters, basis_size, basis_width) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?) "
                "RETURNING id",
                (*state, *key),
            )
            entry.identifier = rows[0][0]
        self._file.execute("DELETE FROM iteration WHERE entry = ?", (entry.identifier,))
        for iteration in entry.iterations:
            self._store_iteration(entry.identifier, iteration)

    def delete(self, identifier: int) -> None:
        """Remove an entry with all its iterations."""
        self._file.execute("DELETE FROM entry WHERE id = ?", (identifier,))

    def _store_iteration(self, identifier: int, iteration: Iteration) -> None:
        fitted = (getattr(iteration, name) for name in FITTED)
        self._file.execute(
            "INSERT INTO iteration (entry, number, learned_from, weights, errors, gains, "
            "feedback, error_weights, reference_weights) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
            (
                identifier,
                iteration.number,
                iteration.learned_from,
                json.dumps(iteration.weights.tolist()),
                json.dumps(iteration.errors) if iteration.errors else None,
                json.dumps(iteration.gains) if iteration.errors else None,
                *(None if weights is None else json.dumps(weights.tolist()) for weights in fitted),
            ),
        )

    def _entry(self, row: tuple[Any, ...]) -> Entry:
        rows = self._file.execute(
            f"SELECT {', '.join(IterationRow.model_fields)} FROM iteration "
            "WHERE entry = ? ORDER BY number",
            (row[0],),
        )
        try:
            iterations = [_checked(IterationRow, each) for each in rows]
            return _checked(EntryRow, row).entry(iterations)
        except ValueError as error:  # of pydantic, or one of ours for shapes and rules
            raise DatabaseError(
                self._file.path,
                f"holds a damaged entry {row[0]} ({' '.join(str(error).split())})",
                "restore a copy, or delete that row of the table 'entry'",
            ) from error


def _checked(kind: type[AnyDocument], row: tuple[Any, ...]) -> AnyDocument:
    return kind.model_validate(dict(zip(kind.model_fields, row, strict=True)))
