"""The database of learned feedforward terms, one SQLite file."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import platformdirs

from tsd_casadi.database.database_file import DatabaseFile
from tsd_casadi.database.entry_rows import EntryRows
from tsd_casadi.exceptions import EntryNotFound, InvalidValue
from tsd_casadi.generalization.entry_regression import (
    EntryRegressions,
    describe_entries,
    describe_motion,
)
from tsd_casadi.generalization.suggestion import Region, Suggestion, suggest
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.instruction import USUAL, Instruction
from tsd_casadi.learning.recording import Recording
from tsd_casadi.motions.parameter import complete_parameters


def default_path() -> Path:
    """Find the database in the user's data folder, which is made if there is none."""
    folder = Path(platformdirs.user_data_dir("tsd_casadi"))
    with suppress(OSError):  # opening the file says what is wrong
        folder.mkdir(parents=True, exist_ok=True)
    return folder / "feedforward.sqlite"


class Database:
    """Learned feedforward terms by robot, motion and parameters of the motion.

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
        self._regressions = EntryRegressions()
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
        """Read entries, in the order of their identifiers.

        Args:
            robot: Only of this robot.
            motion: Only of this motion.
        """
        with self._file.transaction():
            return self._rows.read(robot, motion)

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
        """
        key = recording.key
        parameters = complete_parameters(key.motion, dict(key.parameters))
        key = EntryKey.of(key.robot, key.motion, key.axes, parameters)
        with self._file.transaction("IMMEDIATE"):
            entry = self._rows.find(key)
            if entry is not None and instruction.restart:
                self._rows.delete(entry.identifier)
                entry = None
            if entry is None:
                entry = Entry(key, recording.basis, recording.context)
            notes = entry.add(recording, instruction)
            self._rows.store(entry)
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
        with self._file.transaction("IMMEDIATE"):
            for entry in self._rows.read():
                if entry.identifier == identifier:
                    self._rows.delete(identifier)
                    return entry
        raise EntryNotFound(f"no entry {identifier}; 'tsd database list' shows what there is")

    def query(
        self,
        motion: str,
        /,
        *,
        robot: str | None = None,
        kind: str | None = None,
        extrapolate: bool = False,
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
            parameters: SI units; those with a default may be left out.

        Raises:
            InvalidValue: If a parameter is missing or makes no sense, or the
                kind is unknown.
            EntryNotFound: If nothing fits.
            OutsideTrainedRange: If it would be an extrapolation.
        """
        if kind not in (None, "learned", "generalised"):
            raise InvalidValue("kind", repr(kind), "learned or generalised")
        complete = complete_parameters(motion, parameters)
        entries = self._candidates(motion, robot)
        wanted = EntryKey.of("", motion, (), complete).parameters
        exact = [entry for entry in entries if entry.key.parameters == wanted]
        if exact and kind in (None, "learned"):
            # the same parameters with other axes are another entry: the newest counts
            return max(exact, key=lambda entry: (entry.updated, entry.identifier)).feedforward()
        if kind == "learned":
            raise EntryNotFound(
                f"no entry for {describe_motion(motion, wanted)}; there is "
                f"{describe_entries(entries)}. Learn it with 'tsd learn {motion}', or ask for a "
                "generalised feedforward"
            )
        return self._regressions.generalize(motion, entries, dict(wanted), extrapolate)

    def suggest(
        self,
        motion: str,
        /,
        *,
        robot: str | None = None,
        region: Region,
        **parameters: float,
    ) -> Suggestion:
        """Choose the parameters of a motion whose repetition would teach most.

        Args:
            motion: Name of the motion, for instance 'squat'.
            robot: May be left out while there is only one.
            region: (low, high) of each parameter that may be chosen, SI units.
            parameters: The others, SI units; those with a default may be left out.

        Returns:
            Parameters, with the predicted standard deviation there.

        Raises:
            InvalidValue: If a parameter is missing or makes no sense, or the
                region is empty.
            EntryNotFound: If the entries do not fit together, or every place in
                the region has one.
        """
        entries = self._candidates(motion, robot)
        return suggest(motion, entries, self._regressions, region, parameters)

    def _candidates(self, motion: str, robot: str | None) -> list[Entry]:
        entries = self.entries(robot, motion)
        robots = sorted({entry.key.robot for entry in entries})
        if len(robots) > 1:
            raise EntryNotFound(f"name the robot, the database knows {', '.join(robots)}")
        return entries
