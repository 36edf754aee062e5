from __future__ import annotations

from typing import Any

import pytest

from tsd_server.kept_replies import KEPT_REPLIES, KeptReplies
from tsd_server.tally import Tally
from tsd_server.waiting_line import WAITING_QUERIES, Taken, WaitingLine


class Query:
    """Stands for a query of Zenoh."""

    dropped = False

    def drop(self) -> None:
        self.dropped = True


def answer(query: Any) -> None:
    """Answer nothing."""


def taken(query: Query) -> Taken:
    tally = Tally()
    tally.take()
    return Taken(query, answer, tally)  # type: ignore[arg-type]


def test_queries_are_taken_in_their_order() -> None:
    line, queries = WaitingLine(), [taken(Query()), taken(Query())]
    for query in queries:
        line.put(query)
    assert [line.take(), line.take()] == queries
    line.close()
    assert line.take() is None


def test_of_too_many_the_oldest_is_dropped() -> None:
    line, queries = WaitingLine(), [taken(Query()) for _ in range(WAITING_QUERIES + 1)]
    for query in queries[:-1]:
        line.put(query)
    assert not any(each.query.dropped for each in queries)
    line.put(queries[-1])
    assert [each.query.dropped for each in queries] == [True] + [False] * WAITING_QUERIES
    # nor is it counted as waiting any more
    assert [each.tally.message().waiting for each in queries] == [0] + [1] * WAITING_QUERIES
    assert line.take() == queries[1]


def test_replies_are_kept_until_the_database_changes() -> None:
    kept = KeptReplies()
    assert kept.find("a", 1) is None
    kept.keep("a", b"one", 1)
    assert kept.find("a", 1) == b"one"
    assert kept.find("a", 2) is None
    # it changed while the reply was made: nobody knows of which version it is
    kept.keep("a", b"two", 3)
    assert kept.find("a", 2) is None


@pytest.mark.parametrize(("number", "is_kept"), [(0, False), (1, True), (KEPT_REPLIES, True)])
def test_the_oldest_reply_of_too_many_goes(number: int, is_kept: bool) -> None:
    kept = KeptReplies()
    kept.find("", 1)
    for each in range(KEPT_REPLIES + 1):
        kept.keep(str(each), b"", 1)
    assert (kept.find(str(number), 1) is not None) == is_kept
