"""The pipe from a run to the process that publishes it: never waited for."""

from __future__ import annotations

import os
import select
import struct
import time
from collections.abc import Iterator
from contextlib import suppress

ROWS, EVENT = b"R", b"E"
# tag and length of what follows
FRAME = struct.Struct("<cI")
# what is read at once [bytes], as much as a pipe of Linux holds
CHUNK = 65536


class Feed:
    """The run's end of the pipe.

    Rows for which there is no room are dropped; events wait, and go before later rows.

    Attributes:
        is_broken: Whether nobody reads any more; all that is sent is dropped then.
    """

    def __init__(self, descriptor: int) -> None:
        """Take over a file descriptor that is written to."""
        os.set_blocking(descriptor, False)
        self._descriptor = descriptor
        self._left = bytearray()
        self.is_broken = self._is_closed = False

    def send_rows(self, body: bytes) -> bool:
        """Send rows if there is room for them; says whether they were sent."""
        self._push()
        if self._left or self.is_broken:
            return False
        self._left += FRAME.pack(ROWS, len(body)) + body
        self._push()
        return not self.is_broken

    def send_event(self, body: bytes) -> None:
        """Send an event, now or before what is sent next."""
        if not self.is_broken:
            self._left += FRAME.pack(EVENT, len(body)) + body
            self._push()

    def close(self, patience: float) -> None:
        """Send what is left and close the pipe.

        Args:
            patience: How long that may take at the most [s].
        """
        if self._is_closed:
            return
        end = time.monotonic() + patience
        self._push()
        while self._left and not self.is_broken and (left := end - time.monotonic()) > 0:
            select.select([], [self._descriptor], [], left)
            self._push()
        with suppress(OSError):
            os.close(self._descriptor)
        self._is_closed = self.is_broken = True

    def _push(self) -> None:
        while self._left and not self.is_broken:
            try:
                sent = os.write(self._descriptor, self._left)
            except BlockingIOError:
                return
            except OSError:
                self.is_broken = True
                self._left.clear()
                return
            del self._left[:sent]


def read_feed(descriptor: int, parent: int) -> Iterator[tuple[bytes, bytes]]:
    """Read what is sent until the other end is closed, or its process is gone.

    Args:
        descriptor: Of the pipe.
        parent: Process that sends; a child of its own could hold the pipe open.

    Yields:
        ROWS or EVENT, and the body.
    """
    kept = bytearray()
    while os.getppid() == parent:
        # four times a second: who watches is told within one that the run is gone
        if not select.select([descriptor], [], [], 0.25)[0]:
            continue
        chunk = os.read(descriptor, CHUNK)
        if not chunk:
            return
        kept += chunk
        while len(kept) >= FRAME.size:
            tag, length = FRAME.unpack_from(kept)
            end = FRAME.size + length
            if len(kept) < end:
                break
            yield tag, bytes(kept[FRAME.size : end])
            del kept[:end]
