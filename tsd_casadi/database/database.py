"""The database of learned feedforward terms, one SQLite file."""

from __future__ import annotations

from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path

import platformdirs

from tsd_casadi.database.answering import UNKNOWN_CONTEXT
from tsd_casadi.database.completion import complete
from tsd_casadi.database.damaged_entry import DamagedEntry
from tsd_casadi.database.database_file import DatabaseFile
from tsd_casadi.database.kept_entries import KeptEntries
from tsd_casadi.database.new_rows import NewRows
from tsd_casadi.database.reading import Reading
from tsd_casadi.database.transfer import Imported, read_entries, write_entries
from tsd_casadi.database.verification import find_damages
from tsd_casadi.exceptions import EntryNotFound
from tsd_casadi.learning.context import NOWHERE
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.instruction import USUAL, Instruction
from tsd_casadi.learning.plausible import check_plausible, check_size
from tsd_casadi.learning.recording import Recording


def default_path() -> Path:
    """Find the database in the user's data folder, which is made if there is none."""
    folder = Path(platformdirs.user_data_dir("tsd_casadi"))
    with suppress(OSError):  # opening the file says what is wrong
        folder.mkdir(parents=True, exist_ok=True)
    return folder / "feedforward.sqlite"


class Database(Reading):
    """Learned feedforward terms by robot, motion, its parameters, axes and context.

    Every method is one transaction, so a process that dies in between loses
    nothing that was answered.

    Attributes:
        path: The file.
    """

    def __init__(self, path: str | Path, kept: KeptEntries | None = None) -> None:
        """Open a database file, or make one.

        Args:
            path: A file in a folder that exists.
            kept: Decoded entries, shared with other connections to the file.

        Raises:
            DatabaseError: If it cannot be opened or is not one of ours.
        """
        super().__init__(path, kept)
        self._new_rows = NewRows(self._file, self._rows)

    def _open(self) -> DatabaseFile:
        return DatabaseFile(self.path)

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
                recording lacks what the rule needs, or cannot be what a robot did.
            IncompatibleEntry: If it does not fit the entry.
            DatabaseError: If the entry is damaged, or the file cannot be written.
        """
        check_size(recording.laps, recording.basis)
        with self._file.transaction("IMMEDIATE"):
            key = recording.key
            recording = complete(recording, self._declaration(key.robot, key.motion, key.version))
            # with the parameters that have a default: what is said of a motion tells them
            check_plausible(recording)
            # whoever names the same axes in another order learns the same
            recording = recording.along(self._index.known_order(recording.key))
            key = recording.key
            entry, notes = self._find(key), []
            if entry is not None and instruction.restart:
                self._new_rows.forget(entry.identifier, _now())
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
            self._new_rows.add(entry, "recorded")
        self._read_back(entry.key)
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
            entry = self._rows.entry(identifier)
            self._new_rows.forget(identifier, _now())
        self._kept.forget(identifier)
        return entry if isinstance(entry, Entry) else None

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
            for entry in incoming:
                if self._index.exact(entry.key) is None:
                    self._new_rows.add(entry, "imported")
                    added += 1
        return Imported(added, len(incoming) - added)

    def verify(self) -> list[str]:
        """Check everything in the file.

        Returns:
            What is wrong, a sentence each; nothing if all is well.
        """
        with self._file.transaction():
            return find_damages(self._file, self._rows)

    def _read_back(self, key: EntryKey) -> None:
        """Decode what the file serves now, so that whoever asks next need not.

        A robot asks for what it has just recorded. What is kept is read from the file,
        so that nobody is ever served what is not there.
        """
        with self._file.transaction():
            indexed = self._index.exact(key)
            if indexed is not None:
                self._rows.served(indexed)

    def _find(self, key: EntryKey) -> Entry | None:
        """Read the entry of a key; one of unknown context where there is no other.

        Raises:
            DatabaseError: If it is damaged.
        """
        nowhere = EntryKey(key.robot, key.motion, key.version, key.axes, key.parameters, NOWHERE)
        indexed = self._index.exact(key) or self._index.exact(nowhere)
        if indexed is None:
            return None
        entry = self._rows.entry(indexed.identifier)
        if isinstance(entry, DamagedEntry):
            raise entry.error(self.path)
        return entry


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
