"""A mistyped name beside the one that it resembles."""

from __future__ import annotations

from collections.abc import Iterable

# names that a reader of an error message looks through
FEW = 6


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


def nearest(name: str, known: Iterable[str]) -> str:
    """Name the few of many names that one resembles most, to be put behind 'one of'.

    Returns:
        "one of 'left_sole', 'left_foot' and 61 others", all of them if they are few.
    """
    from difflib import get_close_matches

    names = list(dict.fromkeys(known))
    if len(names) <= FEW:
        shown = names
    else:
        lower = {each.lower(): each for each in reversed(names)}
        close = get_close_matches(name.lower(), lower, n=FEW, cutoff=0.4)
        shown = [lower[each] for each in close] or names[:FEW]
    others = len(names) - len(shown)
    return f"one of {', '.join(shown)}" + (f" and {others} others" if others else "")
