"""A log whose writer was killed, made whole."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.whole_file import write_whole
from tsd_clients.logs.log_file import MCAP, check_log_path

if TYPE_CHECKING:
    from tsd_clients.logs.copy_mcap import Copied


def recover_log(path: Path, target: Path) -> Copied:
    """Write everything that can be read of an MCAP file into one that is whole.

    What is lost is the last chunk, which was being written, and chunks that were
    damaged since.

    Args:
        path: The log.
        target: May be the same file, which then is replaced when all is written, unless
            it is whole.

    Returns:
        What was kept.

    Raises:
        InvalidValue: If it is no MCAP file, has nothing that could be kept, or the
            target cannot be written.
        NotAvailable: If the library for it is not installed.
        OSError: If it cannot be read.
    """
    if path.suffix.lower() != MCAP:
        raise InvalidValue(
            "log file", f"'{path}'", f"a {MCAP}: others are written whole or not at all"
        )
    check_log_path(path)
    from tsd_clients.logs.copy_mcap import copy_mcap
    from tsd_clients.logs.mcap_file import begin_mcap

    if path == target:
        with path.open("rb") as source, open(os.devnull, "wb") as nowhere:
            looked_at = copy_mcap(source, begin_mcap(nowhere))
        if looked_at.is_whole and not looked_at.damaged:
            return looked_at
    with path.open("rb") as source, write_whole(target) as file:
        copied = copy_mcap(source, begin_mcap(file))
        if not copied.tells:
            raise InvalidValue(
                "log file",
                f"'{path}'",
                "one that 'tsd simulate --log' wrote, with its beginning undamaged",
            )
    return copied
