"""The process that writes the log of a run, away from its loop.

Run: python -m tsd_clients.logs.write_mcap FILE

Reads frames from stdin: outline and settings first, then rows, vetoes and at most one
request without a solution, a summary at the end. Says 'ready' when the file is open. Whatever
ends the run, also its kill, ends stdin, and the file is made whole.
"""

from __future__ import annotations

import json
import os
import struct
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from tsd_clients.logs.run_summary import KILLED
from tsd_clients.logs.unblocked_pipe import CAPACITY, FRAME

OUTLINE, SETTINGS, ROW, VETO = b"o", b"g", b"r", b"v"
REQUEST, OUTCOME, SUMMARY = b"q", b"e", b"s"
BEGAN = struct.Struct("<Q")
READY = b"ready\n"
# between two readings [s]: rows come by the dozen, and the loop wakes nobody up
PAUSE = 0.02
# rows that are turned into messages at once; more of them would only take more memory
MOST_ROWS = 256


class Frames:
    """Frames put together from the pieces in which they come.

    Attributes:
        rest: The beginning of a frame that is not complete.
    """

    def __init__(self) -> None:
        """Start with nothing."""
        self.rest = bytearray()

    def take(self, piece: bytes) -> list[tuple[bytes, bytes]]:
        """Give the frames, kind and content, that are complete with a piece."""
        self.rest += piece
        found, start = [], 0
        while len(self.rest) - start >= FRAME.size:
            kind, size = FRAME.unpack_from(self.rest, start)
            stop = start + FRAME.size + size
            if len(self.rest) < stop:
                break
            found.append((kind, bytes(self.rest[start + FRAME.size : stop])))
            start = stop
        del self.rest[:start]
        return found


class Writing:
    """What becomes of the frames."""

    def __init__(self, file: BinaryIO) -> None:
        """Begin the file."""
        # the loop, which shares the words of this module, does without the library
        from tsd_clients.logs.mcap_file import begin_mcap

        self._file, self._writer = file, begin_mcap(file)
        self._rows: list[bytes] = []
        self._end: dict[str, Any] = {"aborted": KILLED}
        file.flush()

    def take(self, kind: bytes, content: bytes) -> None:
        """Write a frame, or keep a row until there are more."""
        if kind == ROW:
            self._rows.append(content)
            if len(self._rows) >= MOST_ROWS:
                self.write_rows()
            return
        self.write_rows()
        if kind == OUTLINE:
            # heavy, and the file is there already
            from tsd_casadi.wire.run_outline import RunOutline
            from tsd_clients.logs.mcap_recording import McapRecording

            (began,) = BEGAN.unpack_from(content)
            self._outline = RunOutline.decode(content[BEGAN.size :])
            self._recording = McapRecording(self._writer, self._outline, began)
        elif kind == SETTINGS:
            self._recording.add_settings(content)
        elif kind == VETO:
            self._recording.add_veto(content.decode())
        elif kind == REQUEST:
            self._recording.add_request(content)
        elif kind in (OUTCOME, SUMMARY):
            self._end = json.loads(content)

    def write_rows(self) -> None:
        """Write the rows that were kept."""
        from tsd_clients.logs.tick_columns import tick_columns

        if self._rows:
            rows = np.frombuffer(b"".join(self._rows), "<f8").reshape(len(self._rows), -1)
            self._recording.add_ticks(tick_columns(rows, self._outline))
            self._rows = []
            self._file.flush()

    def finish(self) -> None:
        """Make the file whole."""
        self.write_rows()
        self._recording.finish(self._end)
        self._file.flush()


def write(path: Path, source: int) -> None:
    """Write a log until there is nothing more to come.

    Args:
        path: The file; what was there is gone.
        source: Where the frames come from, a file descriptor.
    """
    frames = Frames()
    with path.open("wb") as file:
        writing = Writing(file)
        os.write(sys.stdout.fileno(), READY)
        while piece := os.read(source, CAPACITY):
            for kind, content in frames.take(piece):
                writing.take(kind, content)
            writing.write_rows()
            time.sleep(PAUSE)
        writing.finish()


def stand_back() -> None:
    """Let whatever moves the robot go first, at once.

    A process that is only nice is not interrupted for a millisecond or more when a tick
    is due on its core. On a computer that has no time left rows wait in the run's memory,
    and are written when it has ended.
    """
    with suppress(OSError):  # a container may forbid it
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))


def main() -> None:
    """Write the log that the one argument names; what goes wrong is one line on stderr."""
    stand_back()
    try:
        write(Path(sys.argv[1]), sys.stdin.fileno())
    except Exception as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        sys.stderr.write(f"{reason}\n")
        sys.exit(1)


if __name__ == "__main__":
    main()
