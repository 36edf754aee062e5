"""Late replies are dropped by their question's number, and unread questions do not pile up."""

from __future__ import annotations

import time
from typing import Any

from tsd_clients.remote.tick_exchange import MOST_OPEN, TickExchange


class Querier:
    """Keeps the questions, to be replied to by hand."""

    def __init__(self) -> None:
        self.asked: list[Any] = []

    def get(self, handler: Any, *, payload: bytes) -> None:
        self.asked.append(handler)

    def reply(self, question: int, reply: object) -> None:
        self.asked[question].callback(reply)

    def close(self, question: int) -> None:
        self.asked[question].drop()


def now() -> float:
    return time.monotonic()


def test_the_reply_to_the_newest_question_is_given() -> None:
    querier = Querier()
    exchange = TickExchange(querier)
    assert exchange.ask(1, b"", now())
    querier.reply(0, "one")
    assert exchange.next(now()) == (True, "one")
    querier.close(0)
    assert exchange.next(now()) == (True, None)
    assert exchange.late == 0


def test_what_does_not_come_by_the_deadline_is_dropped_later() -> None:
    querier = Querier()
    exchange = TickExchange(querier)
    assert exchange.ask(1, b"", now())
    assert exchange.next(now()) == (False, None)
    assert exchange.ask(2, b"", now())
    querier.reply(0, "late")
    querier.close(0)
    assert exchange.next(now()) == (False, None)
    querier.reply(1, "two")
    assert exchange.next(now()) == (True, "two")
    assert exchange.late == 1


def test_questions_that_nobody_reads_are_few() -> None:
    querier = Querier()
    exchange = TickExchange(querier)
    sent = [exchange.ask(sequence, b"", now()) for sequence in range(MOST_OPEN + 3)]
    assert sent == [True] * MOST_OPEN + [False] * 3
    assert len(querier.asked) == MOST_OPEN
    querier.close(0)
    assert exchange.ask(MOST_OPEN + 3, b"", now())
    assert len(querier.asked) == MOST_OPEN + 1
