"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from tsd_casadi.exceptions import InvalidValue


@contextmanager
def write_whole(path: str | Path) -> Iterator[BinaryIO]:
    """Open a file that takes the place of what is at the path when all is written.

    Whatever ends the block early, an error or the user, leaves what was there
    before. What is no regular file, such as /dev/null or a pipe, is written
    to directly.

    Yields:
        The file, binary.

    Raises:
        InvalidValue: If it cannot be written.
    """
    # through a symbolic link to what it names
    target = Path(path).resolve()
    direct = target.exists() and not target.is_file()
    part = target if direct else target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        try:
            with part.open("wb") as file:
                yield file
            if not direct:
                if target.exists():
                    shutil.copymode(target, part)
                os.replace(part, target)
        finally:
            if not direct:
                part.unlink(missing_ok=True)
    except OSError as error:
        raise _refusal(path, error.strerror or str(error)) from error


def check_writable(path: str | Path) -> None:
    """Refuse a file that could not be written, before the work and without leaving a trace.

    Raises:
        InvalidValue: If its folder is missing, or file or folder cannot be written to.
    """
    target = Path(path).resolve()
    if target.is_dir():
        raise _refusal(path, "is a folder")
    if not target.parent.is_dir():
        raise _refusal(path, f"there is no folder {target.parent}")
    if target.exists() and not os.access(target, os.W_OK):
        raise _refusal(path, "the file cannot be written to")
    # a new file takes the old one's place, so the folder counts
    special = target.exists() and not target.is_file()
    if not special and not os.access(target.parent, os.W_OK | os.X_OK):
        raise _refusal(path, "the folder cannot be written to")


def _refusal(path: str | Path, reason: str) -> InvalidValue:
    return InvalidValue("output file", f"'{path}' ({reason})", "a writable path")
