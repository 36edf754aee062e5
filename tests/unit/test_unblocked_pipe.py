from __future__ import annotations

import os
import threading

from hypothesis import given, settings
from hypothesis import strategies as st

from tsd_clients.logs.unblocked_pipe import CAPACITY, UnblockedPipe
from tsd_clients.logs.write_mcap import Frames


def read_all(descriptor: int, pieces: list[bytes]) -> None:
    while piece := os.read(descriptor, 1 << 16):
        pieces.append(piece)


@settings(max_examples=15)
@given(st.lists(st.binary(max_size=40).map(lambda each: each * 5000), max_size=12))
def test_nothing_is_lost_while_nobody_reads(contents: list[bytes]) -> None:
    source, target = os.pipe()
    pipe = UnblockedPipe(target)
    for content in contents:
        pipe.put(b"r", content)  # more than fits: would block for ever
    pieces: list[bytes] = []
    reader = threading.Thread(target=read_all, args=(source, pieces))
    reader.start()
    pipe.flush()
    pipe.close()
    reader.join()
    os.close(source)
    frames = Frames()
    found = [frame for piece in pieces for frame in frames.take(piece)]
    assert found == [(b"r", content) for content in contents]
    assert not frames.rest


def test_a_reader_that_is_gone_stops_nobody() -> None:
    source, target = os.pipe()
    pipe = UnblockedPipe(target)
    pipe.put(b"r", bytes(3 * CAPACITY))
    os.close(source)
    pipe.put(b"r", b"x")
    assert pipe.is_broken
    pipe.flush()
    pipe.put(b"r", b"y")
    pipe.close()
    pipe.close()
