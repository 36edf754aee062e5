"""What a service tells its user."""

from __future__ import annotations

from contextlib import suppress
from typing import TextIO


def say(text: str, stream: TextIO) -> None:
    """Tell the user; that nobody reads it is no reason to stop serving.

    Args:
        text: One line.
        stream: Standard output or error.
    """
    with suppress(OSError, ValueError):
        print(text, file=stream, flush=True)
