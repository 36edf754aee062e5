"""Entries as rows of the tables."""

from __future__ import annotations

import json
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

import numpy as np

from tsd_casadi.database.database_file import DatabaseFile
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import DatabaseError
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.learning.recording import Context
from tsd_casadi.learning.rules.by_name import find_rule

# what a test leaves in its iteration, as weights
FITTED = ("feedback", "error_weights", "reference_weights")


class EntryRows:
    """Reads and writes entries; the caller begins and ends the transactions."""

    def __init__(self, file: DatabaseFile) -> None:
        """Take an open file."""
        self._file = file

    def read(self, robot: str | None = None, motion: str | None = None) -> list[Entry]:
        """Entries, in the order of their identifiers.

        Args:
            robot: Only of this robot.
            motion: Only of this motion.

        Raises:
            DatabaseError: If one is damaged.
        """
        rows = self._file.execute(
            "SELECT id, robot, task, axes, parameters, basis_size, basis_width, context, "
            "learning_gain, rule, updated FROM entry "
            "WHERE (?1 IS NULL OR robot = ?1) AND (?2 IS NULL OR task = ?2) ORDER BY id",
            (robot, motion),
        )
        return [self._checked_entry(row) for row in rows]

    def find(self, key: EntryKey) -> Entry | None:
        """The entry of a key, if there is one."""
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

    def _checked_entry(self, row: tuple[Any, ...]) -> Entry:
        try:
            return self._entry(row)
        except (ValueError, TypeError, KeyError) as error:
            raise DatabaseError(
                self._file.path,
                f"holds a damaged entry {row[0]} ({error})",
                "restore a copy, or delete that row of the table 'entry'",
            ) from error

    def _entry(self, row: tuple[Any, ...]) -> Entry:
        axes, parameters, context = (json.loads(row[i]) for i in (3, 4, 7))
        return Entry(
            key=EntryKey.of(row[1], row[2], tuple(axes), parameters),
            basis=PeriodicBasis(row[5], row[6]),
            context=Context(**context),
            iterations=self._iterations(row[0]),
            learning_gain=row[8],
            rule=find_rule(row[9]),
            identifier=row[0],
            updated=row[10],
        )

    def _iterations(self, identifier: int) -> list[Iteration]:
        rows = self._file.execute(
            "SELECT number, learned_from, weights, errors, gains, feedback, error_weights, "
            "reference_weights FROM iteration WHERE entry = ? ORDER BY number",
            (identifier,),
        )
        return [
            Iteration(
                number,
                np.array(json.loads(weights)),
                json.loads(errors) if errors else None,
                json.loads(gains) if gains else None,
                learned_from=learned_from,
                **{
                    name: np.array(json.loads(text)) if text else None
                    for name, text in zip(FITTED, fitted, strict=True)
                },
            )
            for number, learned_from, weights, errors, gains, *fitted in rows
        ]
