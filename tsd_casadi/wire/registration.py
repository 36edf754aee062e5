"""A service's place in the run directory, which only one can have."""

from __future__ import annotations

import fcntl
import hashlib
import os
import time
from contextlib import suppress
from pathlib import Path

from tsd_casadi.exceptions import AlreadyRunning
from tsd_casadi.wire.run_directory import run_directory
from tsd_casadi.wire.run_record import RunRecord, is_at, opened, read_record

# whoever looks what runs here holds a lock for an instant; only one that is held for
# longer is a service's [s]
GLANCE = 0.3


class Registration:
    """A record that stands in the run directory until it is closed, or the process ends."""

    def __init__(self, record: RunRecord) -> None:
        """Take the place of the record's role and subject.

        Raises:
            AlreadyRunning: If it is taken.
            RunDirectoryUnusable: If the run directory is not one.
        """
        folder = run_directory()
        name = hashlib.sha256(record.subject.encode()).hexdigest()[:16]
        self._path = folder / f"{record.role}-{name}.json"
        end = time.monotonic() + GLANCE
        while (file := _take(self._path)) is None:
            if time.monotonic() > end:
                raise _taken(record, self._path)
            time.sleep(0.01)
        self._file = file
        os.ftruncate(file, 0)
        os.pwrite(file, record.encode(), 0)

    def __enter__(self) -> Registration:
        """Use as a context manager."""
        return self

    def __exit__(self, *_: object) -> None:
        """Give the place up."""
        self.close()

    def close(self) -> None:
        """Give the place up."""
        with suppress(FileNotFoundError):
            self._path.unlink()
        os.close(self._file)  # and the lock with it


def _take(path: Path) -> int | None:
    """Lock the file of a place; None if it is locked, or was taken away meanwhile."""
    file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(file)
        return None
    if is_at(file, path):
        return file
    os.close(file)
    return None


def _taken(record: RunRecord, path: Path) -> AlreadyRunning:
    with opened(path) as file:
        first = None if file is None else read_record(file)
    if first is None:
        return AlreadyRunning(record.role, record.subject)
    where = ", ".join(first.endpoints)
    return AlreadyRunning(record.role, record.subject, first.pid, where, first.started)
