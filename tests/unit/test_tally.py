from __future__ import annotations

import threading
import time

from tsd_server.tally import Tally


def test_answers_refusals_and_failures_are_counted_by_kind() -> None:
    tally = Tally()
    for _ in range(5):
        tally.take()
    now = time.perf_counter()
    tally.answer(now)
    tally.refuse("invalid_value", now)
    tally.refuse("invalid_value", now)
    tally.fail("ZeroDivisionError", now - 60.0)
    tally.drop()
    message = tally.message()
    assert message.answered == 1
    assert message.refused == {"invalid_value": 2}
    assert message.failed == {"ZeroDivisionError": 1}
    assert message.waiting == 4
    assert sum(message.latency.counts) == 4
    assert message.latency.counts[-1] == 1


def test_none_is_lost_between_threads() -> None:
    tally = Tally()

    def count() -> None:
        for _ in range(2000):
            tally.take()
            tally.answer(time.perf_counter())
            tally.drop()

    threads = [threading.Thread(target=count) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    message = tally.message()
    assert message.waiting == 0
    assert message.answered == sum(message.latency.counts) == 8000
