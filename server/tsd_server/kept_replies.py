"""Replies to what is asked over and over, until the database changes."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable

# some 5 kB each
KEPT_REPLIES = 1_000


class KeptReplies:
    """Encoded replies by the question that asked for them, for one thread."""

    def __init__(self) -> None:
        """Keep nothing yet."""
        self._replies: OrderedDict[Hashable, bytes] = OrderedDict()
        self._version: object = None

    def find(self, question: Hashable, version: object) -> bytes | None:
        """Find a reply; all are forgotten once the version is another.

        Args:
            version: Of the database, see ``Reading.version``.
        """
        if version != self._version:
            self._replies.clear()
            self._version = version
        return self._replies.get(question)

    def keep(self, question: Hashable, body: bytes, version: object) -> None:
        """Keep a reply, unless the database has changed since it was looked for.

        Args:
            version: Of the database after the reply was made.
        """
        if version != self._version:
            return
        self._replies[question] = body
        if len(self._replies) > KEPT_REPLIES:
            self._replies.popitem(last=False)  # the oldest
