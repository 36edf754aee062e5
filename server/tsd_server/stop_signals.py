"""The main thread's sleep while a service serves."""

from __future__ import annotations

import io
import os
import signal
from contextlib import suppress

from tsd_server.end_at_once import STOPPING


class StopSignals:
    """Wakes the main thread when the first SIGINT or SIGTERM comes.

    The kernel may give a signal to any thread, Zenoh's among them, and Python runs
    a handler only once its main thread wakes up. So the main thread waits for a
    byte that the C part of Python's handler writes, whichever thread that runs in.
    """

    def __init__(self) -> None:
        """Prepare; signals do what they did before."""
        reader, writer = os.pipe()
        os.set_blocking(writer, False)
        self._reader = io.FileIO(reader, "r")
        self._writer = io.FileIO(writer, "w")

    def __enter__(self) -> StopSignals:
        """Catch the signals from now on."""
        self._wakeup = signal.set_wakeup_fd(self._writer.fileno(), warn_on_full_buffer=False)
        # nothing to do in Python, but only signals with a handler wake anybody
        self._before = [signal.signal(number, _ignore) for number in STOPPING]
        return self

    def __exit__(self, *_: object) -> None:
        """Let the signals do what they did before: a second one waits for nothing."""
        for number, handler in zip(STOPPING, self._before, strict=True):
            # None: not set by Python, so not to be given back by it either
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        signal.set_wakeup_fd(self._wakeup)

    def wait(self) -> None:
        """Wait until a signal came or ``wake`` was called."""
        self._reader.read(1)

    def wake(self) -> None:
        """End the wait; may be called in any thread, also when nobody waits any more."""
        with suppress(ValueError):  # closed
            self._writer.write(b"\0")

    def close(self) -> None:
        """Give the pipe back."""
        self._reader.close()
        self._writer.close()


def _ignore(number: int, frame: object) -> None:
    """Do nothing: the byte in the pipe says it all."""
