from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsd_casadi.exceptions import LayoutMismatch, MalformedMessage, UnsupportedVersion
from tsd_casadi.wire.tick_message import (
    HEADER,
    HEADER_FIELDS,
    MAGIC,
    REPLY,
    REQUEST,
    VERSION,
    pack_tick,
    unpack_tick,
)

UINT64 = st.integers(0, 2**64 - 1)
LAYOUT = 0x0123456789ABCDEF
KINDS = st.sampled_from([REQUEST, REPLY])
VALUES = st.lists(st.floats(width=64), min_size=1, max_size=50)


def a_message(size: int = 3) -> bytes:
    return pack_tick(REQUEST, LAYOUT, 7, np.arange(float(size)), instance=9)


@given(kind=KINDS, layout=UINT64, sequence=UINT64, instance=UINT64, values=VALUES)
def test_what_is_packed_is_unpacked_bit_for_bit(
    kind: int, layout: int, sequence: int, instance: int, values: list[float]
) -> None:
    payload = pack_tick(kind, layout, sequence, np.array(values), instance)
    message = unpack_tick(payload, kind, layout, len(values))
    assert (message.sequence, message.instance) == (sequence, instance)
    assert message.values.tobytes() == np.array(values).tobytes()  # NaN and -0.0 too


def test_bytes_are_the_documented_ones() -> None:
    # a client in any language can pack this
    payload = pack_tick(REPLY, LAYOUT, 5, np.array([1.0, -2.5]), instance=2**63)
    assert payload == b"TSDT" + struct.pack("<HHQQQ2d", 1, 2, LAYOUT, 5, 2**63, 1.0, -2.5)
    assert len(payload) == 32 + 2 * 8


def test_header_fields_describe_the_header() -> None:
    assert sum(field[0] for field in HEADER_FIELDS) == HEADER.size == 32
    assert [field[2] for field in HEADER_FIELDS] == [
        "magic",
        "version",
        "kind",
        "layout",
        "sequence",
        "instance",
    ]


def test_big_endian_and_strided_arrays_are_packed_as_little_endian() -> None:
    values = np.arange(6.0)
    expected = pack_tick(REQUEST, LAYOUT, 0, values[::2].copy())
    assert pack_tick(REQUEST, LAYOUT, 0, values[::2]) == expected
    assert pack_tick(REQUEST, LAYOUT, 0, values[::2].astype(">f8")) == expected


@pytest.mark.parametrize("length", [0, 1, 31])
def test_less_than_a_header_is_refused(length: int) -> None:
    with pytest.raises(MalformedMessage, match=f"^{length} bytes; expected a header of 32"):
        unpack_tick(a_message()[:length], REQUEST, LAYOUT, 3)


@pytest.mark.parametrize("length", [32, 33, 40, 55])
def test_a_truncated_message_is_refused(length: int) -> None:
    with pytest.raises(MalformedMessage, match="expected 3 float64"):
        unpack_tick(a_message()[:length], REQUEST, LAYOUT, 3)


@pytest.mark.parametrize("more", [1, 7, 8, 1000])
def test_an_extended_message_is_refused(more: int) -> None:
    with pytest.raises(MalformedMessage, match=f"{24 + more} bytes after the header"):
        unpack_tick(a_message() + bytes(more), REQUEST, LAYOUT, 3)


@pytest.mark.parametrize("magic", [b"TSDU", b"tsdt", bytes(4), MAGIC[::-1]])
def test_another_magic_is_refused(magic: bytes) -> None:
    with pytest.raises(MalformedMessage, match="magic") as caught:
        unpack_tick(magic + a_message()[4:], REQUEST, LAYOUT, 3)
    assert type(caught.value) is MalformedMessage


@pytest.mark.parametrize("version", [0, VERSION + 1, 0xFFFF])
def test_another_version_is_refused_as_such(version: int) -> None:
    payload = a_message()
    payload = payload[:4] + struct.pack("<H", version) + payload[6:]
    with pytest.raises(UnsupportedVersion, match=f"version {version}; expected version 1"):
        unpack_tick(payload, REQUEST, LAYOUT, 3)


def test_another_version_is_noticed_whatever_follows() -> None:
    payload = MAGIC + struct.pack("<H", VERSION + 1) + bytes(26)
    with pytest.raises(UnsupportedVersion):
        unpack_tick(payload, REQUEST, LAYOUT, 3)


@pytest.mark.parametrize(("packed", "wanted"), [(REQUEST, REPLY), (REPLY, REQUEST), (3, REPLY)])
def test_another_kind_is_refused(packed: int, wanted: int) -> None:
    payload = pack_tick(packed, LAYOUT, 0, np.zeros(3))
    with pytest.raises(MalformedMessage, match=f"kind {packed}; expected {wanted}"):
        unpack_tick(payload, wanted, LAYOUT, 3)


@pytest.mark.parametrize("layout", [0, LAYOUT + 1, LAYOUT ^ (1 << 63)])
def test_another_layout_is_refused_as_such(layout: int) -> None:
    with pytest.raises(LayoutMismatch, match=r"query info again") as caught:
        unpack_tick(a_message(), REQUEST, layout, 3)
    assert f"{LAYOUT:#018x}" in str(caught.value)


def test_another_layout_is_the_reason_even_if_the_size_differs_too() -> None:
    with pytest.raises(LayoutMismatch):
        unpack_tick(a_message(5), REQUEST, LAYOUT + 1, 3)


@settings(max_examples=settings.default.max_examples * 3)
@given(payload=st.binary(max_size=120))
def test_arbitrary_bytes_are_always_refused_as_malformed(payload: bytes) -> None:
    with pytest.raises(MalformedMessage):
        unpack_tick(payload, REQUEST, LAYOUT, 3)


@settings(max_examples=settings.default.max_examples * 3)
@given(where=st.integers(0, 31), bit=st.integers(0, 7), cut=st.integers(0, 56))
def test_damaged_messages_are_unpacked_or_refused_as_malformed(
    where: int, bit: int, cut: int
) -> None:
    payload = bytearray(a_message())
    payload[where] ^= 1 << bit
    try:
        message = unpack_tick(bytes(payload[:cut]), REQUEST, LAYOUT, 3)
    except MalformedMessage:
        return
    # only sequence and instance may be anything
    assert cut == 56
    assert where >= 16
    np.testing.assert_array_equal(message.values, np.arange(3.0))


def test_values_cannot_be_written_to_by_accident() -> None:
    message = unpack_tick(a_message(), REQUEST, LAYOUT, 3)
    with pytest.raises(ValueError, match="read-only"):
        message.values[0] = 1.0
