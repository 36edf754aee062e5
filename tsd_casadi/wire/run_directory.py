"""Which services run here: a private folder with a locked file for each.

A service holds a lock on its file for as long as it lives, so a file without a lock is
a service that is gone, however it ended; whoever finds one takes it away. What a
service serves has a lock too, which is held by one of them at a time: a second
controller for a robot, or learner for a database, is refused and the first one named.
"""

from __future__ import annotations

import fcntl
import os
import stat
from contextlib import suppress
from pathlib import Path

from tsd_casadi.exceptions import RunDirectoryUnusable
from tsd_casadi.wire.run_record import RunRecord, is_at, opened, read_record

# instead of the user's own folder
ENVIRONMENT = "TSD_RUN_DIR"


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
        with opened(path) as file:
            if file is None:
                continue
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                record = read_record(file)
                if record is not None:
                    found.append(record)
            else:
                # ours for a moment: nobody can have taken the place meanwhile
                if is_at(file, path):
                    path.unlink()
    return found


def is_stopped(pid: int) -> bool:
    """Whether a process is frozen, by SIGSTOP or a debugger; False where that is unknown."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (OSError, IndexError):
        return False
    return state in "Tt"
