"""Bytes to another process that may be slow: whoever hands them over never waits for it."""

from __future__ import annotations

import fcntl
import os
import select
import struct
from collections import deque
from contextlib import suppress

# largest that a user may ask for by default (/proc/sys/fs/pipe-max-size)
CAPACITY = 1 << 20
# what is handed over at once from what waits: 10 us of copying
MOST_AT_ONCE = 65536
FRAME = struct.Struct("<cI")  # kind, size of what follows


class UnblockedPipe:
    """Keeps what the reader has no room for in memory; nothing is lost while it lives.

    Attributes:
        is_broken: Whether the reader is gone.
    """

    def __init__(self, descriptor: int) -> None:
        """Take over the writing end of a pipe."""
        self._descriptor, self.is_broken = descriptor, False
        self._waiting: deque[memoryview] = deque()
        os.set_blocking(descriptor, False)
        # refused to who has many pipes: more waits in memory instead
        with suppress(OSError):
            fcntl.fcntl(descriptor, fcntl.F_SETPIPE_SZ, CAPACITY)

    def put(self, kind: bytes, content: bytes) -> None:
        """Hand a frame over, or keep it for later."""
        if self.is_broken:
            return
        self._waiting.append(memoryview(FRAME.pack(kind, len(content)) + content))
        self._hand_over(MOST_AT_ONCE)

    def flush(self) -> None:
        """Wait until the reader has taken everything, or is gone."""
        while self._waiting and not self.is_broken:
            select.select([], [self._descriptor], [])
            self._hand_over(CAPACITY)

    def close(self) -> None:
        """Tell the reader that this is all; what waits is lost."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor, self.is_broken = -1, True
        self._waiting.clear()

    def _hand_over(self, most: int) -> None:
        while self._waiting and most > 0:
            first = self._waiting[0][:most]
            try:
                taken = os.write(self._descriptor, first)
            except BlockingIOError:
                return
            except BrokenPipeError:
                self.is_broken = True
                self._waiting.clear()
                return
            most -= taken
            if taken < len(self._waiting[0]):
                self._waiting[0] = self._waiting[0][taken:]
                return
            self._waiting.popleft()
