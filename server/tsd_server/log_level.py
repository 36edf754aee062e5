"""What a service tells on stderr while it runs."""

from __future__ import annotations

import logging
import sys

LEVELS = ("debug", "info", "warning", "error")
LINE = "%(asctime)s %(levelname)s %(name)s: %(message)s"


def show_log(level: str | None) -> None:
    """Write the log of all our packages to stderr, in Python's own logging.

    Args:
        level: The least that is told, one of LEVELS; None leaves logging as it is,
            which tells warnings and errors.
    """
    if level is not None:
        logging.basicConfig(level=level.upper(), format=LINE, stream=sys.stderr)
