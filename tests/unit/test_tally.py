from __future__ import annotations

import threading

import pytest

from tsd_casadi.exceptions import InvalidValue
from tsd_server.tally import Tally


def test_answers_refusals_and_failures_are_counted_by_kind() -> None:
    tally = Tally()
    with tally.counting():
        pass
    for _ in range(2):
        with pytest.raises(InvalidValue), tally.counting():
            raise InvalidValue("amplitude", 5, "less")
    with pytest.raises(ZeroDivisionError), tally.counting():
        _ = 1 / 0
    tally.waiting = 3
    message = tally.message()
    assert message.answered == 1
    assert message.refused == {"invalid_value": 2}
    assert message.failed == {"ZeroDivisionError": 1}
    assert message.waiting == 3
    assert sum(message.latency.counts) == 4


def test_none_is_lost_between_threads() -> None:
    tally = Tally()

    def count() -> None:
        for _ in range(2000):
            with tally.counting():
                pass

    threads = [threading.Thread(target=count) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    message = tally.message()
    assert message.answered == sum(message.latency.counts) == 8000
