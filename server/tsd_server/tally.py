"""What became of the queries on one key, counted."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

from tsd_casadi.exceptions import TsdError
from tsd_casadi.wire.health import AnswersMessage
from tsd_casadi.wire.latency import LatencyHistogram


class Tally:
    """Counts answers, refusals and failures; may be used by several threads.

    Attributes:
        waiting: Queries that were taken up and are not answered yet.
    """

    def __init__(self) -> None:
        """Start with none."""
        self.waiting = 0
        self._answered = 0
        self._refused: Counter[str] = Counter()
        self._failed: Counter[str] = Counter()
        self._latency = LatencyHistogram()
        self._counting = threading.Lock()

    @contextmanager
    def counting(self) -> Iterator[None]:
        """Count one answer by how the block ends, and its time."""
        start = time.perf_counter()
        try:
            yield
        except TsdError as error:
            self._count(start, self._refused, error.code)
            raise
        except Exception as error:
            self._count(start, self._failed, type(error).__name__)
            raise
        self._count(start)

    def _count(self, start: float, kinds: Counter[str] | None = None, kind: str = "") -> None:
        with self._counting:
            if kinds is None:
                self._answered += 1
            else:
                kinds[kind] += 1
            self._latency.add(time.perf_counter() - start)

    def message(self) -> AnswersMessage:
        """Write what was counted by now."""
        with self._counting:
            return AnswersMessage(
                answered=self._answered,
                refused=dict(self._refused),
                failed=dict(self._failed),
                waiting=self.waiting,
                latency=self._latency.message(),
            )
