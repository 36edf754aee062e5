"""A mistyped name beside the one that it resembles."""

from __future__ import annotations

from collections.abc import Iterable


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Ask for the names that one resembles, to be put behind a message.

    Returns:
        "; did you mean 'height'?", or nothing if it resembles none.
    """
    from difflib import get_close_matches

    names = list(known)
    same = [each for each in names if each.lower() == name.lower()]
    close = same or get_close_matches(name, names, n=2)
    return f"; did you mean {' or '.join(repr(each) for each in close)}?" if close else ""
