from __future__ import annotations

import os
from collections.abc import Iterator
from io import FileIO

import pytest

from tsd_clients.telemetry.feed import EVENT, ROWS, Feed, read_feed


@pytest.fixture
def pipe() -> Iterator[tuple[FileIO, Feed]]:
    reads, writes = os.pipe()
    feed = Feed(writes)
    with FileIO(reads) as end:
        yield end, feed
        feed.close(0.0)


def test_what_is_sent_arrives_in_order_and_the_end_is_told(pipe: tuple[FileIO, Feed]) -> None:
    reads, feed = pipe
    sent = [(ROWS, b"a" * 5), (EVENT, b""), (ROWS, b"b"), (EVENT, b"c" * 1000)]
    for tag, body in sent:
        if tag == ROWS:
            assert feed.send_rows(body)
        else:
            feed.send_event(body)
    feed.close(1.0)
    assert list(read_feed(reads.fileno(), os.getppid())) == sent


def test_rows_are_dropped_where_nobody_reads_and_events_are_kept(pipe: tuple[FileIO, Feed]) -> None:
    reads, feed = pipe
    rows = [b"%06d" % number * 1000 for number in range(100)]
    kept = [body for body in rows if feed.send_rows(body)]
    # the pipe holds 65,536 bytes; the last one sent is in it in part
    assert 10 <= len(kept) < 20
    assert kept == rows[: len(kept)]
    events = [b"event %d" % number * 100 for number in range(100)]
    for event in events:
        feed.send_event(event)
    assert not feed.send_rows(b"late")
    got = []
    source = read_feed(reads.fileno(), os.getppid())
    for tag, body in source:
        got.append((tag, body))
        feed.send_event(b"")  # goes on with what is left
        if body == events[-1]:
            break
    got = [item for item in got if item[1]]
    assert got == [(ROWS, body) for body in kept] + [(EVENT, body) for body in events]
    assert feed.send_rows(b"again there is room")


def test_nothing_is_sent_where_nobody_is(pipe: tuple[FileIO, Feed]) -> None:
    reads, feed = pipe
    reads.close()
    assert not feed.send_rows(b"rows")
    assert feed.is_broken
    feed.send_event(b"event")
    feed.close(1.0)


def test_a_reader_without_its_parent_ends_though_the_pipe_is_open(
    pipe: tuple[FileIO, Feed],
) -> None:
    reads, feed = pipe
    feed.send_event(b"event")
    nobody = 0
    assert list(read_feed(reads.fileno(), nobody)) == []
