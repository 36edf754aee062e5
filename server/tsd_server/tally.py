"""What became of the queries on one key, counted."""

from __future__ import annotations

import threading
import time
from collections import Counter

from tsd_casadi.wire.health import AnswersMessage
from tsd_casadi.wire.latency import LatencyHistogram


class Tally:
    """Counts answers, refusals and failures; may be used by several threads."""

    def __init__(self) -> None:
        """Start with none."""
        self._waiting = 0
        self._answered = 0
        self._refused: Counter[str] = Counter()
        self._failed: Counter[str] = Counter()
        self._latency = LatencyHistogram()
        self._counting = threading.Lock()

    def take(self) -> None:
        """Count a query that was taken up."""
        with self._counting:
            self._waiting += 1

    def drop(self) -> None:
        """Count it no more: it was answered, or dropped."""
        with self._counting:
            self._waiting -= 1

    def answer(self, since: float) -> None:
        """Count a query that was answered with what it asked for.

        Args:
            since: When it was taken up, of ``time.perf_counter`` [s].
        """
        with self._counting:
            self._answered += 1
            self._latency.add(time.perf_counter() - since)

    def refuse(self, code: str, since: float) -> None:
        """Count a query that was answered with an error, by its code; since as above."""
        self._count(self._refused, code, since)

    def fail(self, kind: str, since: float) -> None:
        """Count a query that met a defect, by the kind of exception; since as above."""
        self._count(self._failed, kind, since)

    def _count(self, kinds: Counter[str], kind: str, since: float) -> None:
        with self._counting:
            kinds[kind] += 1
            self._latency.add(time.perf_counter() - since)

    def message(self) -> AnswersMessage:
        """Write what was counted by now."""
        with self._counting:
            return AnswersMessage(
                answered=self._answered,
                refused=dict(self._refused),
                failed=dict(self._failed),
                waiting=self._waiting,
                latency=self._latency.message(),
            )
