"""Which entries a list of the database is to have, as text of a selector."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from tsd_casadi.exceptions import InvalidValue

# entries in one reply, some 1 kB each
LARGEST_PAGE = 1_000
_NUMBER = re.compile(r"[0-9]{1,18}", re.ASCII)  # as large as SQLite's may be
_MOTION = re.compile(r"[A-Za-z][A-Za-z0-9_.]{0,99}", re.ASCII)
_FIELDS = ("motion", "limit", "after", "forget")


@dataclass(frozen=True)
class Listing:
    """A page of the database.

    Attributes:
        motion: Only of this motion.
        limit: Largest number of entries; those that were recorded last.
        after: Those that come after this number instead: page by page with the last
            number of the page before, from 0 on.
        forget: Number of an entry to be forgotten first.
    """

    motion: str | None = None
    limit: int = LARGEST_PAGE
    after: int | None = None
    forget: int | None = None

    @classmethod
    def of(cls, texts: Mapping[str, str]) -> Listing:
        """Read the texts of a selector.

        Raises:
            InvalidValue: If a field is unknown or makes no sense.
        """
        for name in texts:
            if name not in _FIELDS:
                raise InvalidValue("a field of the list", repr(name[:100]), ", ".join(_FIELDS))
        motion = texts.get("motion")
        if motion is not None and _MOTION.fullmatch(motion) is None:
            raise InvalidValue("motion", repr(motion[:100]), "a name of letters, digits, _ and .")
        limit = _number(texts, "limit", "a number of entries")
        if limit is not None and not 1 <= limit <= LARGEST_PAGE:
            raise InvalidValue("limit", limit, f"1 to {LARGEST_PAGE}; 'after' gives the next ones")
        return cls(
            motion,
            LARGEST_PAGE if limit is None else limit,
            _number(texts, "after", "the number of an entry, or 0"),
            _number(texts, "forget", "the number of an entry"),
        )

    def texts(self) -> dict[str, str]:
        """Write it as texts of a selector."""
        fields = {name: getattr(self, name) for name in _FIELDS}
        return {name: str(value) for name, value in fields.items() if value is not None}


def _number(texts: Mapping[str, str], name: str, expected: str) -> int | None:
    text = texts.get(name)
    if text is None:
        return None
    if _NUMBER.fullmatch(text) is None:
        raise InvalidValue(name, repr(text[:100]), expected)
    return int(text)
