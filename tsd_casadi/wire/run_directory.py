"""Which services run here: a private folder with a locked file for each.

A service holds a lock on its file for as long as it lives, so a file without a lock is
a service that is gone, however it ended; whoever finds one takes it away. What a
service serves has a lock too, which is held by one of them at a time: a second
controller for a robot, or learner for a database, is refused and the first one named.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from tsd_casadi.document import Document
from tsd_casadi.exceptions import AlreadyRunning, MalformedMessage, RunDirectoryUnusable

# instead of the user's own folder
ENVIRONMENT = "TSD_RUN_DIR"
# a record is some hundred bytes; more is none of ours [bytes]
LARGEST = 100_000
# whoever looks what runs here holds a lock for an instant; only one that is held for
# longer is a service's [s]
GLANCE = 0.3


class RunRecord(Document):
    """What runs, in a file of the run directory.

    Attributes:
        format: Name and version of this document.
        role: 'controller', 'learner', or what else can be watched.
        subject: What it serves, once on this machine: the robot or the database file.
        robot: Name of the robot; ``*`` for a learner.
        pid: Number of the process.
        endpoints: Where it listens.
        instance: Id of the service, as in its replies.
        started: ISO 8601, UTC.
        telemetry: Where it can be watched, if it can.
    """

    format: Literal["tsd.run/1"] = "tsd.run/1"
    role: str
    subject: str
    robot: str
    pid: Annotated[int, Field(gt=0)]
    endpoints: tuple[str, ...]
    instance: Annotated[int, Field(ge=0)]
    started: str
    telemetry: str | None = None

    @classmethod
    def of_this_process(
        cls, role: str, subject: str, *, robot: str, endpoints: tuple[str, ...], instance: int
    ) -> RunRecord:
        """Describe a service that this process is about to be."""
        return cls(
            role=role,
            subject=subject,
            robot=robot,
            pid=os.getpid(),
            endpoints=endpoints,
            instance=instance,
            started=datetime.now(UTC).isoformat(timespec="seconds"),
        )


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
    if _is_at(file, path):
        return file
    os.close(file)
    return None


def _taken(record: RunRecord, path: Path) -> AlreadyRunning:
    with _opened(path) as file:
        first = None if file is None else _read(file)
    if first is None:
        return AlreadyRunning(record.role, record.subject)
    where = ", ".join(first.endpoints)
    return AlreadyRunning(record.role, record.subject, first.pid, where, first.started)


def run_directory() -> Path:
    """Find the folder, and make it if there is none.

    Returns:
        ``$TSD_RUN_DIR``, else ``tsd`` in ``$XDG_RUNTIME_DIR``, else in the user's cache.

    Raises:
        RunDirectoryUnusable: If it is not a folder of the user's that nobody else
            can enter.
    """
    folder = _wanted()
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with suppress(FileExistsError):
            folder.mkdir(mode=0o700)
        found = folder.lstat()
    except OSError as error:
        raise RunDirectoryUnusable(folder, f"{error.strerror}") from error
    if not stat.S_ISDIR(found.st_mode):
        raise RunDirectoryUnusable(folder, "it is no folder")
    if found.st_uid != os.geteuid():
        raise RunDirectoryUnusable(folder, "it belongs to another user")
    if found.st_mode & 0o077:
        raise RunDirectoryUnusable(folder, "others can enter it")
    return folder


def _wanted() -> Path:
    if os.environ.get(ENVIRONMENT):
        return Path(os.environ[ENVIRONMENT]).absolute()
    if os.environ.get("XDG_RUNTIME_DIR"):
        return Path(os.environ["XDG_RUNTIME_DIR"]) / "tsd"
    from platformdirs import user_cache_path

    return user_cache_path("tsd_casadi") / "run"


def running() -> list[RunRecord]:
    """List what runs here, by role and subject; files of what is gone are taken away.

    Raises:
        RunDirectoryUnusable: If the run directory is not one.
    """
    found = []
    for path in sorted(run_directory().glob("*.json")):
        with _opened(path) as file:
            if file is None:
                continue
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                record = _read(file)
                if record is not None:
                    found.append(record)
            else:
                # ours for a moment: nobody can have taken the place meanwhile
                if _is_at(file, path):
                    path.unlink()
    return found


def is_stopped(pid: int) -> bool:
    """Whether a process is frozen, by SIGSTOP or a debugger; False where that is unknown."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (OSError, IndexError):
        return False
    return state in "Tt"


@contextmanager
def _opened(path: Path) -> Iterator[int | None]:
    try:
        file = os.open(path, os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW)
    except OSError:  # gone meanwhile, or none of ours
        yield None
        return
    try:
        yield file
    finally:
        os.close(file)


def _read(file: int) -> RunRecord | None:
    """Read a record; None while its owner is about to write it."""
    try:
        return RunRecord.decode(os.pread(file, LARGEST, 0))
    except MalformedMessage:
        return None


def _is_at(file: int, path: Path) -> bool:
    """Whether the file that was opened is the one that stands there now."""
    try:
        return os.path.samestat(os.fstat(file), path.stat())
    except FileNotFoundError:
        return False
