"""Queries that take their time, answered one after another beside the quick ones."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import zenoh

# as many as wait for the service itself
WAITING_QUERIES = 64

Answer = Callable[[zenoh.Query], None]


class WaitingLine:
    """Queries that wait for one thread; of too many the oldest is dropped.

    Its client notices that at once: a query that is dropped has no reply.
    """

    def __init__(self) -> None:
        """Let nothing wait yet."""
        self._condition = threading.Condition()
        self._waiting: deque[tuple[zenoh.Query, Answer]] = deque()
        self._is_closed = False

    def put(self, query: zenoh.Query, answer: Answer) -> None:
        """Let a query wait.

        Args:
            answer: Replies to it, and may raise what any answer may.
        """
        with self._condition:
            self._waiting.append((query, answer))
            dropped = self._waiting.popleft() if len(self._waiting) > WAITING_QUERIES else None
            self._condition.notify()
        if dropped is not None:
            dropped[0].drop()  # type: ignore[no-untyped-call]

    def take(self) -> tuple[zenoh.Query, Answer] | None:
        """Wait for the next query; None once the line is closed."""
        with self._condition:
            self._condition.wait_for(lambda: self._waiting or self._is_closed)
            return None if self._is_closed else self._waiting.popleft()

    def close(self) -> None:
        """Let nobody wait any more."""
        with self._condition:
            self._is_closed = True
            self._condition.notify_all()


@dataclass(frozen=True)
class Later:
    """What a quick answer returns when the query is to wait in a line.

    Attributes:
        line: Where.
        answer: Replies to it.
    """

    line: WaitingLine
    answer: Answer
