from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.exceptions import LayoutMismatch, MalformedMessage, UnsupportedVersion
from tsd_casadi.tick.layout import Field, Layout, hash_layouts
from tsd_casadi.wire.telemetry_rows import (
    HEADER,
    HEADER_FIELDS,
    SINCE,
    pack_rows,
    repetition_of,
    telemetry_layout,
    unpack_rows,
)

ROW = Layout((Field("time", 1, "s", ""), Field("q", 3, "rad", "")))
LAYOUT = telemetry_layout(ROW)
HASH = hash_layouts([LAYOUT])


def test_a_published_row_begins_with_what_a_log_notes() -> None:
    assert LAYOUT.size == ROW.size + len(SINCE)
    for part in ROW:
        assert LAYOUT.slice(part.name) == ROW.slice(part.name)


def test_the_header_is_as_its_table_says() -> None:
    assert HEADER.size == sum(size for size, *_ in HEADER_FIELDS) == 32


@given(
    st.integers(0, 20),
    st.integers(0, 2**32 - 1),
    st.integers(0, 2**32 - 1),
    st.integers(0, 2**64 - 1),
    st.integers(0, 2**32 - 1),
)
def test_rows_come_out_as_they_went_in(
    count: int, repetition: int, dropped: int, event: int, seed: int
) -> None:
    rows = np.random.default_rng(seed).normal(size=(count, LAYOUT.size))
    rows[:, 0] = np.nan  # what nobody knows
    payload = pack_rows(HASH, rows, repetition=repetition, dropped=dropped, event=event)
    found = unpack_rows(payload, HASH, LAYOUT.size)
    np.testing.assert_array_equal(found.rows, rows)
    assert (found.repetition, found.dropped, found.event) == (repetition, dropped, event)
    assert repetition_of(payload) == repetition


@given(st.binary(max_size=400))
def test_what_is_no_message_of_rows_is_told(payload: bytes) -> None:
    with pytest.raises((MalformedMessage, UnsupportedVersion, LayoutMismatch)):
        unpack_rows(payload, HASH, LAYOUT.size)


def test_rows_of_another_layout_version_or_length_are_told() -> None:
    payload = pack_rows(HASH, np.zeros((2, LAYOUT.size)), repetition=1)
    with pytest.raises(LayoutMismatch, match="of the run's outline"):
        unpack_rows(payload, HASH + 1, LAYOUT.size)
    with pytest.raises(MalformedMessage, match="rows of 8 float64"):
        unpack_rows(payload[:-8], HASH, LAYOUT.size)
    other = payload[:4] + struct.pack("<H", 2) + payload[6:]
    with pytest.raises(UnsupportedVersion, match="version 2 of rows"):
        unpack_rows(other, HASH, LAYOUT.size)
