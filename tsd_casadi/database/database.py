"""The database of learned feedforward terms, one SQLite file."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

from tsd_casadi.database.schema import prepare
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import DatabaseError, EntryNotFound, InvalidValue
from tsd_casadi.generalization.entry_regression import (
    EntryRegressions,
    describe_entries,
    describe_task,
)
from tsd_casadi.generalization.suggestion import Region, Suggestion, suggest
from tsd_casadi.learning.entry import Entry, Iteration
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.recording import Context, Recording, TaskKey
from tsd_casadi.motions.parameter import complete_parameters

# what a test leaves in its iteration, as weights
FITTED = ("feedback", "error_weights", "reference_weights")


def default_path() -> Path:
    """The database in the user's data folder."""
    return Path(platformdirs.user_data_dir("tsd_casadi")) / "feedforward.sqlite"


class Database:
    """Learned feedforward terms by robot, task and task parameters.

    Every method is one transaction, so a process that dies in between loses
    nothing that was answered.

    Attributes:
        path: The file.
    """

    def __init__(self, path: str | Path) -> None:
        """Open a database file, or make one.

        Args:
            path: The file.

        Raises:
            DatabaseError: If it cannot be opened or is not one of ours.
        """
        self.path = Path(path).expanduser()
        self._regressions = EntryRegressions()
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._connection = sqlite3.connect(self.path, isolation_level=None)
        except (OSError, sqlite3.Error) as error:
            raise DatabaseError(
                self.path, f"cannot be opened ({error})", "name a file in a folder you may write to"
            ) from error
        try:
            prepare(self._connection)
        except sqlite3.OperationalError as error:
            self._connection.close()
            raise DatabaseError(
                self.path,
                f"cannot be read ({error})",
                "check permissions, free disk space and whether another process holds it",
            ) from error
        except sqlite3.DatabaseError as error:
            self._connection.close()
            raise DatabaseError(
                self.path,
                f"is not a database of this project ({error})",
                "name another file with --database; this one was not changed",
            ) from error

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    def __enter__(self) -> Database:
        """Use as a context manager."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self.close()

    def entries(self, robot: str | None = None, task: str | None = None) -> list[Entry]:
        """Entries, in the order of their identifiers.

        Args:
            robot: Only of this robot.
            task: Only of this task.
        """
        with self._transaction():
            return self._read(robot, task)

    def record(self, recording: Recording) -> tuple[Entry, list[str]]:
        """Take in one repetition and learn from it.

        Args:
            recording: The repetition.

        Returns:
            The entry as it is now, and remarks for the user.

        Raises:
            InvalidValue: If a task parameter is missing or makes no sense.
            IncompatibleEntry: If it does not fit the entry.
        """
        key = recording.key
        parameters = complete_parameters(key.task, dict(key.parameters))
        key = TaskKey.of(key.robot, key.task, key.axes, parameters)
        with self._transaction("IMMEDIATE"):
            entry = self._find(key)
            if entry is not None and recording.restart:
                self._delete(entry.identifier)
                entry = None
            if entry is None:
                entry = Entry(key, recording.basis, recording.context)
            notes = entry.add(recording)
            self._store(entry)
        return entry, notes

    def forget(self, identifier: int) -> Entry:
        """Remove an entry with all its iterations.

        Args:
            identifier: Its number.

        Returns:
            The entry that was removed.

        Raises:
            EntryNotFound: If there is none of that number.
        """
        with self._transaction("IMMEDIATE"):
            for entry in self._read():
                if entry.identifier == identifier:
                    self._delete(identifier)
                    return entry
        raise EntryNotFound(f"no entry {identifier}; 'tsd database list' shows what there is")

    def query(
        self,
        /,
        task: str,
        *,
        robot: str | None = None,
        kind: str | None = None,
        extrapolate: bool = False,
        **parameters: float,
    ) -> Feedforward:
        """The feedforward for some task parameters.

        Args:
            task: Name of the motion.
            robot: Name of the robot; may be left out while there is only one.
            kind: 'learned' for the exact entry, 'generalised' for a regression
                over the other entries; by default the exact entry where there
                is one.
            extrapolate: Generalise outside the learned range too.
            parameters: Task parameters, SI units; those with a default may be
                left out.

        Returns:
            The feedforward.

        Raises:
            InvalidValue: If a parameter is missing or makes no sense, or the
                kind is unknown.
            EntryNotFound: If nothing fits.
            OutsideTrainedRange: If it would be an extrapolation.
        """
        if kind not in (None, "learned", "generalised"):
            raise InvalidValue("kind", repr(kind), "learned or generalised")
        complete = complete_parameters(task, parameters)
        entries = self._candidates(task, robot)
        wanted = TaskKey.of("", task, (), complete).parameters
        exact = [entry for entry in entries if entry.key.parameters == wanted]
        if exact and kind in (None, "learned"):
            # the same parameters with other axes are another entry: the newest counts
            return max(exact, key=lambda entry: (entry.updated, entry.identifier)).feedforward()
        if kind == "learned":
            raise EntryNotFound(
                f"nothing was learned for {describe_task(task, wanted)}; there is "
                f"{describe_entries(entries)}. Learn it with 'tsd learn {task}', or ask for a "
                "generalised feedforward"
            )
        return self._regressions.generalise(task, entries, dict(wanted), extrapolate)

    def suggest(
        self,
        /,
        task: str,
        *,
        robot: str | None = None,
        region: Region,
        **parameters: float,
    ) -> Suggestion:
        """The task parameters whose repetition would teach most.

        Args:
            task: Name of the motion.
            robot: Name of the robot; may be left out while there is only one.
            region: (low, high) of each parameter that may be chosen, SI units.
            parameters: The other task parameters, SI units; those with a
                default may be left out.

        Returns:
            Parameters, with the predicted standard deviation there.

        Raises:
            InvalidValue: If a parameter is missing or makes no sense, or the
                region is empty.
            EntryNotFound: If the entries do not fit together, or every place in
                the region has one.
        """
        entries = self._candidates(task, robot)
        return suggest(task, entries, self._regressions, region, parameters)

    def _candidates(self, task: str, robot: str | None) -> list[Entry]:
        entries = self.entries(robot, task)
        robots = sorted({entry.key.robot for entry in entries})
        if len(robots) > 1:
            raise EntryNotFound(f"name the robot, the database knows {', '.join(robots)}")
        return entries

    def _read(self, robot: str | None = None, task: str | None = None) -> list[Entry]:
        rows = self._execute(
            "SELECT id, robot, task, axes, parameters, basis_size, basis_width, context, "
            "learning_gain, rule, updated FROM entry "
            "WHERE (?1 IS NULL OR robot = ?1) AND (?2 IS NULL OR task = ?2) ORDER BY id",
            (robot, task),
        )
        return [self._checked_entry(row) for row in rows]

    def _find(self, key: TaskKey) -> Entry | None:
        for entry in self._read(key.robot, key.task):
            if entry.key == key:
                return entry
        return None

    def _checked_entry(self, row: tuple[Any, ...]) -> Entry:
        try:
            return self._entry(row)
        except (ValueError, TypeError, KeyError) as error:
            raise DatabaseError(
                self.path,
                f"holds a damaged entry {row[0]} ({error})",
                "restore a copy, or delete that row of the table 'entry'",
            ) from error

    def _entry(self, row: tuple[Any, ...]) -> Entry:
        axes, parameters, context = (json.loads(row[i]) for i in (3, 4, 7))
        iterations = [
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
            for number, learned_from, weights, errors, gains, *fitted in self._execute(
                "SELECT number, learned_from, weights, errors, gains, feedback, error_weights, "
                "reference_weights FROM iteration WHERE entry = ? ORDER BY number",
                (row[0],),
            )
        ]
        return Entry(
            key=TaskKey.of(row[1], row[2], tuple(axes), parameters),
            basis=PeriodicBasis(row[5], row[6]),
            context=Context(**context),
            iterations=iterations,
            learning_gain=row[8],
            rule=row[9],
            identifier=row[0],
            updated=row[10],
        )

    def _store(self, entry: Entry) -> None:
        entry.updated = datetime.now(UTC).isoformat(timespec="seconds")
        state = (
            json.dumps(asdict(entry.context)),
            entry.learning_gain,
            entry.rule,
            entry.updated,
        )
        if entry.identifier:
            self._execute(
                "UPDATE entry SET context = ?, learning_gain = ?, rule = ?, updated = ? "
                "WHERE id = ?",
                (*state, entry.identifier),
            )
        else:
            key = (
                entry.key.robot,
                entry.key.task,
                json.dumps(entry.key.axes),
                json.dumps(dict(entry.key.parameters)),
                entry.basis.L,
                entry.basis.width,
            )
            rows = self._execute(
                "INSERT INTO entry (context, learning_gain, rule, updated, robot, task, axes, "
                "parameters, basis_size, basis_width) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?) "
                "RETURNING id",
                (*state, *key),
            )
            entry.identifier = rows[0][0]
        self._execute("DELETE FROM iteration WHERE entry = ?", (entry.identifier,))
        for iteration in entry.iterations:
            self._execute(
                "INSERT INTO iteration (entry, number, learned_from, weights, errors, gains, "
                "feedback, error_weights, reference_weights) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
                (
                    entry.identifier,
                    iteration.number,
                    iteration.learned_from,
                    json.dumps(iteration.weights.tolist()),
                    json.dumps(iteration.errors) if iteration.errors else None,
                    json.dumps(iteration.gains) if iteration.errors else None,
                    *(
                        None if fitted is None else json.dumps(fitted.tolist())
                        for fitted in (getattr(iteration, name) for name in FITTED)
                    ),
                ),
            )

    def _delete(self, identifier: int) -> None:
        self._execute("DELETE FROM entry WHERE id = ?", (identifier,))

    def _execute(self, statement: str, values: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
        try:
            return self._connection.execute(statement, values).fetchall()
        except sqlite3.Error as error:
            raise DatabaseError(
                self.path,
                f"cannot be read or written ({error})",
                "check free disk space, permissions and whether another process holds it",
            ) from error

    @contextmanager
    def _transaction(self, kind: str = "DEFERRED") -> Iterator[None]:
        self._execute(f"BEGIN {kind}")
        try:
            yield
            self._execute("COMMIT")
        finally:
            # after a failure, a failed COMMIT included, unless SQLite did it itself
            if self._connection.in_transaction:
                self._connection.rollback()
