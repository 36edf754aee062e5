"""What is seen of a run's ticks on the wire: a header, then rows of float64.

Everything is little-endian. A row is what a log notes of one tick, and behind it how
the ticks since the row before went, which are not seen.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np

from tsd_casadi.exceptions import LayoutMismatch, MalformedMessage, UnsupportedVersion
from tsd_casadi.state import Matrix
from tsd_casadi.tick.layout import Field, Layout

MAGIC = b"TSDW"
VERSION = 1
HEADER = struct.Struct("<4sHHIIQQ")
# (bytes, type, name, meaning), in the order of HEADER
HEADER_FIELDS = (
    (4, "bytes", "magic", "'TSDW'"),
    (2, "uint16", "version", f"{VERSION}"),
    (2, "uint16", "reserved", "0"),
    (4, "uint32", "repetition", "number of the repetition in its run, from 1 on"),
    (4, "uint32", "dropped", "rows that the run itself had no room for, so far"),
    (8, "uint64", "layout", "hash of the layout of a row"),
    (8, "uint64", "event", "number of the newest event before these rows"),
)
# behind the fields of ``row_layout``: of the ticks since the row before and this one's
SINCE = (
    Field("ticks", 1, "", "how many ticks there were since the row before, with this one"),
    Field("missed_since", 1, "", "how many of them had no answer"),
    Field("tick_us_median", 1, "us", "median of their round trips"),
    Field("tick_us_largest", 1, "us", "the longest of them"),
)


@dataclass(frozen=True)
class TelemetryRows:
    """Unpacked rows.

    Attributes:
        repetition: Number of the repetition in its run, from 1 on.
        dropped: Rows that the run itself had no room for, so far.
        event: Number of the newest event before them.
        rows: (N, size of the layout), writable only if copied.
    """

    repetition: int
    dropped: int
    event: int
    rows: Matrix


def telemetry_layout(row: Layout) -> Layout:
    """Lay out a row that is published.

    Args:
        row: What is noted of a tick, ``row_layout``; it comes first.
    """
    return Layout((*row.fields, *SINCE))


def pack_rows(
    layout: int, rows: Matrix, *, repetition: int, dropped: int = 0, event: int = 0
) -> bytes:
    """Put rows together.

    Args:
        layout: Hash of the ``telemetry_layout``; it takes longer than all the rest.
        rows: (N, size of the layout).
        repetition: Number of the repetition in its run.
        dropped: Rows that were dropped before them.
        event: Number of the newest event before them.
    """
    header = HEADER.pack(MAGIC, VERSION, 0, repetition, dropped, layout, event)
    return header + rows.astype("<f8", copy=False).tobytes()


def repetition_of(payload: bytes) -> int:
    """Read of which repetition rows are, without their layout.

    Raises:
        MalformedMessage: If it is no message of rows.
        UnsupportedVersion: If it is of another version.
    """
    if len(payload) < HEADER.size:
        raise MalformedMessage(f"{len(payload)} bytes", f"a header of {HEADER.size} bytes and rows")
    magic, version, _, repetition, *_ = HEADER.unpack_from(payload)
    if magic != MAGIC:
        raise MalformedMessage(f"magic {magic!r}", repr(MAGIC))
    if version != VERSION:
        raise UnsupportedVersion(f"version {version} of rows", f"version {VERSION}")
    return int(repetition)


def unpack_rows(payload: bytes, layout: int, size: int) -> TelemetryRows:
    """Take rows apart, checking all but the numbers themselves.

    Args:
        layout: Hash of the ``telemetry_layout``.
        size: How many float64 are in a row.

    Raises:
        MalformedMessage: If magic or length are wrong.
        UnsupportedVersion: If it is of another version.
        LayoutMismatch: If it was packed with another layout.
    """
    repetition = repetition_of(payload)
    *_, dropped, found, event = HEADER.unpack_from(payload)
    if found != layout:
        raise LayoutMismatch(
            f"layout {found:#018x} of rows", f"{layout:#018x}, of the run's outline"
        )
    length = len(payload) - HEADER.size
    if length % (8 * size):
        raise MalformedMessage(f"{length} bytes after the header", f"rows of {size} float64")
    numbers = np.frombuffer(payload, dtype="<f8", offset=HEADER.size)
    return TelemetryRows(repetition, dropped, event, numbers.reshape(-1, size))
