"""Queries that take their time, answered one after another beside the quick ones."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import zenoh

from tsd_server.tally import Tally

# as many as wait for the service itself
WAITING_QUERIES = 64


@dataclass(frozen=True)
class Taken:
    """A query that was taken up.

    Attributes:
        query: The query.
        answer: Replies to it, or says in which line it is to wait.
        tally: Where it is counted.
        since: When it was taken up, of ``time.perf_counter`` [s].
    """

    query: Any
    answer: Answer
    tally: Tally
    since: float = field(default_factory=time.perf_counter)

    def drop(self) -> None:
        """Let go of it: its client waits no more."""
        self.query.drop()
        self.tally.drop()


class WaitingLine:
    """Queries that wait for one thread; of too many the oldest is dropped.

    Its client notices that at once: a query that is dropped has no reply.
    """

    def __init__(self) -> None:
        """Let nothing wait yet."""
        self._condition = threading.Condition()
        self._waiting: deque[Taken] = deque()
        self._is_closed = False

    def put(self, taken: Taken) -> None:
        """Let a query wait."""
        with self._condition:
            self._waiting.append(taken)
            dropped = self._waiting.popleft() if len(self._waiting) > WAITING_QUERIES else None
            self._condition.notify()
        if dropped is not None:
            dropped.drop()

    def take(self) -> Taken | None:
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
    answer: Callable[[zenoh.Query], None]


Answer = Callable[[zenoh.Query], Later | None]
