"""Questions and replies of ticks that have a deadline, over a Zenoh querier."""

from __future__ import annotations

import time
from queue import Empty, SimpleQueue
from typing import Any

import zenoh

# Questions under way at once. One is usual; a few more bridge a moment. Beyond that
# nobody reads: more questions would fill the link, and sending would block.
MOST_OPEN = 4


class TickExchange:
    """Sends questions and collects what comes of them, without waiting for any.

    A question is closed by Zenoh when all replies are there, when nobody is there
    to reply, or when its own time-out is over.

    Attributes:
        late: Replies that came after their question's deadline, all of them dropped.
    """

    def __init__(self, querier: Any) -> None:
        """Use a declared querier."""
        self._querier = querier
        # (sequence, reply); None closes the question
        self._arrived: SimpleQueue[tuple[int, Any]] = SimpleQueue()
        self._open: set[int] = set()
        self._newest = 0
        self.late = 0

    def ask(self, sequence: int, payload: bytes, end: float) -> bool:
        """Send a question as soon as few enough are under way; says whether it was sent.

        Args:
            sequence: Its number; what belongs to earlier ones is late from now on.
            end: Until when to wait for that, of ``time.monotonic`` [s].
        """
        self._newest = sequence
        while len(self._open) >= MOST_OPEN:
            if self._take(end - time.monotonic()) is None:
                return False
        self._open.add(sequence)
        put = self._arrived.put
        self._querier.get(
            # in Zenoh's own thread: another one would cost as much as the network
            zenoh.handlers.Callback(
                lambda reply: put((sequence, reply)),
                lambda: put((sequence, None)),
                indirect=False,
            ),
            payload=payload,
        )
        return True

    def next(self, end: float) -> tuple[bool, Any]:
        """Wait for the next that comes of the newest question.

        Args:
            end: Until when to wait, of ``time.monotonic`` [s].

        Returns:
            Whether something came, and the reply; None for a reply if the
            question is closed.
        """
        while True:
            item = self._take(end - time.monotonic())
            if item is None:
                return False, None
            sequence, reply = item
            if sequence == self._newest:
                return True, reply

    def _take(self, seconds: float) -> tuple[int, Any] | None:
        try:
            if seconds > 0:
                sequence, reply = self._arrived.get(timeout=seconds)
            else:
                sequence, reply = self._arrived.get_nowait()
        except Empty:
            return None
        if reply is None:
            self._open.discard(sequence)
        elif sequence != self._newest:
            self.late += 1
        return sequence, reply
