"""A tick on the wire: a header, then the layout's float64 numbers.

Everything is little-endian. ``docs/wire.md`` has the tables, generated from
the definitions here.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np

from tsd_casadi.exceptions import LayoutMismatch, MalformedMessage, UnsupportedVersion
from tsd_casadi.state import Vector

MAGIC = b"TSDT"
VERSION = 1
REQUEST, REPLY = 1, 2
HEADER = struct.Struct("<4sHHQQQ")
# (bytes, type, name, meaning), in the order of HEADER
HEADER_FIELDS = (
    (4, "bytes", "magic", "'TSDT'"),
    (2, "uint16", "version", f"{VERSION}"),
    (2, "uint16", "kind", f"{REQUEST} request, {REPLY} reply"),
    (8, "uint64", "layout", "hash of the layouts, from info"),
    (8, "uint64", "sequence", "chosen by the client, repeated in the reply"),
    (8, "uint64", "instance", "0 in a request; the answering service's id in a reply"),
)
_KINDS = {REQUEST: "request", REPLY: "reply"}


@dataclass(frozen=True)
class TickMessage:
    """An unpacked message.

    Attributes:
        sequence: The client's number of the tick.
        instance: Id of the answering service, 0 in a request.
        values: The layout's numbers, writable only if copied.
    """

    sequence: int
    instance: int
    values: Vector


def pack_tick(kind: int, layout: int, sequence: int, values: Vector, instance: int = 0) -> bytes:
    """Put a message together.

    Args:
        kind: REQUEST or REPLY.
        layout: Hash of both layouts.
        sequence: Counts the ticks of one client.
        values: float64 numbers in the layout's order.
        instance: Of the answering service, 0 in a request.

    Returns:
        The bytes.
    """
    header = HEADER.pack(MAGIC, VERSION, kind, layout, sequence, instance)
    return header + values.astype("<f8", copy=False).tobytes()


def unpack_tick(payload: bytes, kind: int, layout: int, size: int) -> TickMessage:
    """Take a message apart, checking all but the numbers themselves.

    Args:
        kind: REQUEST or REPLY.
        layout: Hash of both layouts.
        size: How many float64 are expected.

    Returns:
        The message.

    Raises:
        MalformedMessage: If magic, kind or length are wrong.
        UnsupportedVersion: If the version is another one.
        LayoutMismatch: If it was packed for other layouts.
    """
    if len(payload) < HEADER.size:
        raise MalformedMessage(
            f"{len(payload)} bytes", f"a header of {HEADER.size} bytes and {size} float64"
        )
    magic, version, found_kind, found_layout, sequence, instance = HEADER.unpack_from(payload)
    if magic != MAGIC:
        raise MalformedMessage(f"magic {magic!r}", repr(MAGIC))
    if version != VERSION:
        raise UnsupportedVersion(f"protocol version {version}", f"version {VERSION}")
    if found_kind != kind:
        raise MalformedMessage(f"kind {found_kind}", f"{kind} ({_KINDS[kind]})")
    if found_layout != layout:
        raise LayoutMismatch(
            f"layout {found_layout:#018x}",
            f"{layout:#018x}, this robot's formulation; query info again and repack",
        )
    length = len(payload) - HEADER.size
    if length != 8 * size:
        raise MalformedMessage(f"{length} bytes after the header", f"{size} float64")
    return TickMessage(sequence, instance, np.frombuffer(payload, dtype="<f8", offset=HEADER.size))
