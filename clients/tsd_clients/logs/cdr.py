"""CDR, in which ROS 2 writes messages: little-endian, numbers aligned to their size.

Source: OMG Common Data Representation, plain CDR version 1 (DDS-XTypes 1.3, 7.4.1).
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence

import numpy as np

from tsd_casadi.state import Vector

# plain CDR, little-endian, no options
HEADER = b"\x00\x01\x00\x00"


class CdrMessage:
    """A message while it is put together, field by field.

    What changes from one message to the next can be left open under a name: all
    messages of one topic then have the same size, and are filled in many at a time.
    """

    def __init__(self) -> None:
        """Begin an empty message."""
        self._bytes = bytearray(HEADER)
        self._open: dict[str, tuple[int, str, int]] = {}

    def add(self, kind: str, *values: float) -> None:
        """Append numbers.

        Args:
            kind: As in ``struct``: 'b', 'i', 'I', 'd'.
        """
        self._align(struct.calcsize(kind))
        self._bytes += struct.pack(f"<{len(values)}{kind}", *values)

    def add_string(self, text: str) -> None:
        """Append a string."""
        encoded = text.encode() + b"\0"
        self.add("I", len(encoded))
        self._bytes += encoded

    def leave_open(self, name: str, kind: str, count: int) -> None:
        """Append numbers that ``fill`` fills in."""
        size = struct.calcsize(kind)
        if count:  # an empty sequence ends with its length
            self._align(size)
        self._open[name] = (len(self._bytes), f"<{kind}", count)
        self._bytes += bytes(size * count)

    @property
    def content(self) -> bytes:
        """The message, with zeros where it is open."""
        return bytes(self._bytes)

    def fill(self, columns: Mapping[str, Vector]) -> list[bytes]:
        """Make messages.

        Args:
            columns: What is open by name, (N,) or (N, count) each.

        Returns:
            N messages.
        """
        count = len(next(iter(columns.values())))
        messages = np.tile(np.frombuffer(self._bytes, np.uint8), (count, 1))
        for name, (start, kind, width) in self._open.items():
            if not width:
                continue
            values = np.ascontiguousarray(columns[name], dtype=kind).reshape(count, width)
            encoded = values.view(np.uint8)
            messages[:, start : start + encoded.shape[1]] = encoded
        return [message.tobytes() for message in messages]

    def read(self, messages: Sequence[bytes]) -> dict[str, Vector]:
        """Read what is open back from messages that ``fill`` made.

        Returns:
            (N, count) each.

        Raises:
            ValueError: If a message is of another size.
        """
        size = len(self._bytes)
        if any(len(message) != size for message in messages):
            raise ValueError(f"a message is not of {size} bytes")
        rows = np.frombuffer(b"".join(messages), np.uint8).reshape(len(messages), size)
        found = {}
        for name, (start, kind, width) in self._open.items():
            stop = start + width * np.dtype(kind).itemsize
            part = np.ascontiguousarray(rows[:, start:stop])
            found[name] = part.view(kind).reshape(len(messages), width)
        return found

    def _align(self, size: int) -> None:
        # counted from behind the header
        self._bytes += bytes(-(len(self._bytes) - len(HEADER)) % size)
