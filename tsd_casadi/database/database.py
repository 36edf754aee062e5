"""The database of learned feedforward terms, one SQLite file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path

import platformdirs

from tsd_casadi.database.answering import UNKNOWN_CONTEXT, Answering
from tsd_casadi.database.answers import Answers
from tsd_casadi.database.completion import complete
from tsd_casadi.database.damaged_entry import DamagedEntry
from tsd_casadi.database.database_file import DatabaseFile
from tsd_casadi.database.entry_rows import EntryRows
from tsd_casadi.database.transfer import Imported, read_entries, write_entries
from tsd_casadi.database.verification import find_damages
from tsd_casadi.exceptions import EntryNotFound
from tsd_casadi.generalization.suggestion import Region, Suggestion
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.instruction import USUAL, Instruction
from tsd_casadi.learning.recording import Recording


def default_path() -> Path:
    """Find the database in the user's data folder, which is made if there is none."""
    folder = Path(platformdirs.user_data_dir("tsd_casadi"))
    with suppress(OSError):  # opening the file says what is wrong
        folder.mkdir(parents=True, exist_ok=True)
    return folder / "feedforward.sqlite"


class Database:
    """Learned feedforward terms by robot, motion, its parameters, axes and context.

    Every method is one transaction, so a process that dies in between loses
    nothing that was answered.

    Attributes:
        path: The file.
    """

    def __init__(self, path: str | Path) -> None:
        """Open a database file, or make one.

        Args:
            path: A file in a folder that exists.

        Raises:
            DatabaseError: If it cannot be opened or is not one of ours.
        """
        self.path = Path(os.path.expanduser(path))  # leaves an unknown user's as it is
        self._answers = Answers(self.path)
        self._file = DatabaseFile(self.path)
        self._rows = EntryRows(self._file)

    def __repr__(self) -> str:
        """Name the file."""
        return f"<Database {self.path}>"

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> Database:
        """Use as a context manager."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self.close()

    def entries(self, robot: str | None = None, motion: str | None = None) -> list[Entry]:
        """Read entries, in the order of their identifiers; ``damaged`` lists what is missing.

        Args:
            robot: Only of this robot.
            motion: Only of this motion.
        """
        with self._file.transaction():
            return self._rows.read(robot, motion)[0]

    def damaged(self, robot: str | None = None, motion: str | None = None) -> list[DamagedEntry]:
        """List entries that cannot be read.

        Args:
            robot: Only of this robot.
            motion: Only of this motion.
        """
        with self._file.transaction():
            return self._rows.read(robot, motion)[1]

    def record(
        self, recording: Recording, instruction: Instruction = USUAL
    ) -> tuple[Entry, list[str]]:
        """Take in one repetition and learn from it.

        Args:
            instruction: By which rule, and whether to learn or to start again.

        Returns:
            The entry as it is now, and remarks for the user.

        Raises:
            InvalidValue: If a parameter is missing or makes no sense, or the
                recording lacks what the rule needs.
            IncompatibleEntry: If it does not fit the entry.
            DatabaseError: If the entry is damaged.
        """
        with self._file.transaction("IMMEDIATE"):
            key = recording.key
            recording = complete(recording, self._rows.read(key.robot, key.motion)[0])
            key = recording.key
            entry, notes = self._rows.find(key), []
            if entry is not None and instruction.restart:
                self._rows.forget(entry.identifier, _now())
                entry = None
            if entry is None:
                entry = Entry(key, recording.basis, recording.circumstances)
            elif entry.key != key:
                notes.append(
                    f"entry {entry.identifier} was {UNKNOWN_CONTEXT}; it is of this one from now on"
                )
                entry.key = key
            notes += entry.add(recording, instruction)
            entry.updated = _now()
            self._rows.add(entry, "recorded")
        return entry, notes

    def forget(self, identifier: int) -> Entry | None:
        """Remove an entry with all its iterations.

        Args:
            identifier: Its number.

        Returns:
            The entry that was removed; None if it could not be read any more.

        Raises:
            EntryNotFound: If there is none of that number.
        """
        with self._file.transaction("IMMEDIATE"):
            if not self._rows.exists(identifier):
                raise EntryNotFound(
                    f"no entry {identifier}; 'tsd database list' shows what there is"
                )
            entries, _ = self._rows.read()
            self._rows.forget(identifier, _now())
        return next((entry for entry in entries if entry.identifier == identifier), None)

    def export(self, path: str | Path) -> int:
        """Write all entries that can be read to a file for another machine.

        Args:
            path: The file; it is written whole or not at all.

        Returns:
            Number of entries.

        Raises:
            InvalidValue: If it cannot be written.
        """
        entries = self.entries()
        write_entries(entries, path)
        return len(entries)

    def import_(self, path: str | Path) -> Imported:
        """Add the entries of such a file, all that are new here or none.

        Args:
            path: A file of ``export``. Entries that are here already, by their
                key, stay as they are.

        Raises:
            InvalidValue: If it cannot be read, is incomplete or damaged.
        """
        incoming = read_entries(path)
        added = 0
        with self._file.transaction("IMMEDIATE"):
            known = {entry.key for entry in self._rows.read()[0]}
            for entry in incoming:
                if entry.key not in known:
                    self._rows.add(entry, "imported")
                    known.add(entry.key)
                    added += 1
        return Imported(added, len(incoming) - added)

    def verify(self) -> list[str]:
        """Check everything in the file.

        Returns:
            What is wrong, a sentence each; nothing if all is well.
        """
        with self._file.transaction():
            return find_damages(self._file, self._rows)

    def query(
        self,
        motion: str,
        /,
        *,
        robot: str | None = None,
        kind: str | None = None,
        extrapolate: bool = False,
        axes: Sequence[str] | None = None,
        context: Context | None = None,
        version: str | None = None,
        **parameters: float,
    ) -> Feedforward:
        """Look up or generalise the feedforward for some parameters of a motion.

        Args:
            motion: Name of the motion, for instance 'squat'.
            robot: May be left out while there is only one.
            kind: 'learned' for the exact entry, 'generalised' for a regression
                over the other entries; by default the exact entry where there
                is one.
            extrapolate: Generalise outside the learned range too.
            axes: Along which it is wanted, names 'task.axis'. An entry for fewer
                of them serves too: the answer names those that it knows.
            context: In which it is wanted; by default that of the newest
                recording, and the answer counts the entries of others. Entries
                of unknown context serve where there is no other.
            version: Of the motion; that of the newest recording by default.
            parameters: SI units; those with a default may be left out.

        Raises:
            InvalidValue: If a parameter is missing or makes no sense, or the
                kind is unknown.
            EntryNotFound: If nothing fits.
            OutsideTrainedRange: If it would be an extrapolation.
            DatabaseError: If the entry with these parameters is damaged.
        """
        entries, damaged = self._candidates(motion, robot)
        for_whom = Answering.among(motion, entries, version, context)
        return self._answers.feedforward(
            for_whom, damaged, parameters, kind=kind, extrapolate=extrapolate, axes=axes
        )

    def suggest(
        self,
        motion: str,
        /,
        *,
        robot: str | None = None,
        region: Region,
        axes: Sequence[str] | None = None,
        context: Context | None = None,
        version: str | None = None,
        **parameters: float,
    ) -> Suggestion:
        """Choose the parameters of a motion whose repetition would teach most.

        Args:
            motion: Name of the motion, for instance 'squat'.
            robot: May be left out while there is only one.
            region: (low, high) of each parameter that may be chosen, SI units.
            axes: As in ``query``.
            context: As in ``query``.
            version: As in ``query``.
            parameters: The others, SI units; those with a default may be left out
                once something is known of the motion.

        Returns:
            Parameters, with the predicted standard deviation there.

        Raises:
            InvalidValue: If a parameter is missing or makes no sense, or the
                region is empty.
            EntryNotFound: If the entries do not fit together, or every place in
                the region has one.
        """
        entries, _ = self._candidates(motion, robot)
        for_whom = Answering.among(motion, entries, version, context)
        return self._answers.suggestion(for_whom, region, parameters, axes)

    def _candidates(self, motion: str, robot: str | None) -> tuple[list[Entry], list[DamagedEntry]]:
        with self._file.transaction():
            entries, damaged = self._rows.read(robot, motion)
        robots = sorted({entry.key.robot for entry in entries})
        if len(robots) > 1:
            raise EntryNotFound(f"name the robot, the database knows {', '.join(robots)}")
        return entries, damaged


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
