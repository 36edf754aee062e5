"""One SQLite file, in transactions."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from tsd_casadi.database.derived import derive, is_derived
from tsd_casadi.database.migration import migrate
from tsd_casadi.database.schema import SCHEMA_VERSION, check_tables, make_tables, read_version
from tsd_casadi.exceptions import DatabaseError, InvalidValue


class DatabaseFile:
    """An open file with our tables; what SQLite has to say arrives as ``DatabaseError``.

    Attributes:
        path: The file.
        connection: SQLite's, for one thread at a time.
    """

    def __init__(self, path: Path) -> None:
        """Open a file, or make one in a folder that exists.

        Raises:
            DatabaseError: If it cannot be opened or is not one of ours.
        """
        self.path = path
        if not path.parent.is_dir():
            raise DatabaseError(
                path,
                f"cannot be opened (there is no folder {path.parent})",
                "name a file in a folder you may write to, or make that one",
            )
        self.connection = _connect(path)
        try:
            self._prepare()
        except sqlite3.OperationalError as error:
            self.close()
            raise DatabaseError(
                path,
                f"cannot be read ({error})",
                "check permissions, free disk space and whether another process holds it",
            ) from error
        except InvalidValue as error:  # of the backup
            self.close()
            raise DatabaseError(
                path,
                f"is of an older version and was not migrated ({error})",
                "make room for a backup beside it",
            ) from error
        except (sqlite3.DatabaseError, ValueError, TypeError, KeyError, RecursionError) as error:
            # besides SQLite's own, text that is none and JSON of older files that is damaged
            self.close()
            raise DatabaseError(
                path,
                f"is not a database of this project ({error})",
                "name another file with --database; this one was not changed",
            ) from error

    @classmethod
    def to_read(cls, path: Path) -> DatabaseFile:
        """Open a file for reading that another connection has prepared, and keeps open.

        Raises:
            DatabaseError: If it cannot be opened.
        """
        file = cls.__new__(cls)
        file.path, file.connection = path, _connect(path)
        file.execute("PRAGMA query_only = ON")
        return file

    def close(self) -> None:
        """Close the file."""
        self.connection.close()

    def version(self) -> tuple[int, int]:
        """Tell what changes whenever anybody writes; inside a transaction, before it."""
        (theirs,) = self.execute("PRAGMA data_version")[0]
        return theirs, self.connection.total_changes

    def size(self) -> int:
        """Tell the size of the file and of what is not yet merged into it [bytes]."""
        return sum(
            path.stat().st_size
            for path in (self.path, self.path.with_name(f"{self.path.name}-wal"))
            if path.exists()
        )

    def _prepare(self) -> None:
        """Make the tables of a new file, bring an older file up to date, check them."""
        if read_version(self.connection) != SCHEMA_VERSION:
            # another process may be at the same: look again once it is done
            self.connection.execute("BEGIN IMMEDIATE")
            version = read_version(self.connection)
            if version == 0:
                make_tables(self.connection)
            elif version < SCHEMA_VERSION:
                migrate(self.connection, self.path, version)
            self.connection.execute("COMMIT")
        check_tables(self.connection)
        with suppress(sqlite3.OperationalError):
            # readers and a writer do not wait for one another; where the file system or an
            # older program that has the file open does not let us, they do, and that is all
            self.connection.execute("PRAGMA journal_mode = WAL")
        # a file that cannot be written to is told now, not at the first recording
        self.connection.execute("BEGIN IMMEDIATE")
        self.connection.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")
        if not is_derived(self.connection):
            derive(self.connection)
        self.connection.execute("COMMIT")
        self.connection.execute("PRAGMA foreign_keys = ON")

    def execute(self, statement: str, values: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
        """Run a statement and read all rows that it answers.

        Args:
            statement: SQL with a placeholder for each value.
            values: Of the placeholders.

        Raises:
            DatabaseError: If the file cannot be read or written.
        """
        try:
            return self.connection.execute(statement, values).fetchall()
        except sqlite3.Error as error:
            raise self._unusable(error) from error

    def read(self, statement: str, values: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
        """Run a statement and read its rows as they are asked for; see ``execute``."""
        try:
            yield from self.connection.execute(statement, values)
        except sqlite3.Error as error:
            raise self._unusable(error) from error

    @contextmanager
    def transaction(self, kind: str = "DEFERRED") -> Iterator[None]:
        """Keep all statements inside, or none of them.

        Args:
            kind: 'IMMEDIATE' keeps other writers out from the start.

        Raises:
            DatabaseError: If it cannot begin or be committed.
        """
        self.execute(f"BEGIN {kind}")
        try:
            yield
            self.execute("COMMIT")
        finally:
            # after a failure, a failed COMMIT included, unless SQLite did it itself
            if self.connection.in_transaction:
                self.connection.rollback()

    def _unusable(self, error: sqlite3.Error) -> DatabaseError:
        return DatabaseError(
            self.path,
            f"cannot be read or written ({error})",
            "check free disk space, permissions and whether another process holds it",
        )


def _connect(path: Path) -> sqlite3.Connection:
    try:
        connection = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
    except sqlite3.Error as error:
        raise DatabaseError(
            path, f"cannot be opened ({error})", "name a file in a folder you may write to"
        ) from error
    # damaged text is for the checksums to tell
    connection.text_factory = lambda text: text.decode(errors="replace")
    return connection
