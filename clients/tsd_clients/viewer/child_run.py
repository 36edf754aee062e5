"""A run of the command line as a child process, whose output is kept."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
import time
from collections import deque
from collections.abc import Sequence

# lines of output that are kept
LINES = 200
# what a table may take on a page, in letters
COLUMNS = 100
# for a run to write down what it has, once it was asked to stop [s]
GRACE = 5.0


class ChildRun:
    """A process that is watched without waiting for it.

    Attributes:
        words: The command.
        began: Monotonic time [s].
    """

    def __init__(self, words: Sequence[str]) -> None:
        """Start it.

        Args:
            words: Program and arguments; no shell reads them.
        """
        self.words = list(words)
        self.began = time.monotonic()
        self._ended: float | None = None
        self._asked_to_stop: float | None = None
        self._lines: deque[str] = deque(maxlen=LINES)
        self._process = subprocess.Popen(
            self.words,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            env={**os.environ, "COLUMNS": str(COLUMNS), "NO_COLOR": "1"},
            # Ctrl-C in the page's terminal is for the page, which stops it
            start_new_session=True,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def output(self) -> str:
        """What it has printed, the last lines of it."""
        return "\n".join(list(self._lines))

    @property
    def code(self) -> int | None:
        """How it ended, 0 for well; None while it runs."""
        return self._process.poll()

    @property
    def seconds(self) -> float:
        """For how long it has run, or ran [s]."""
        if self.code is not None and self._ended is None:
            self._ended = time.monotonic()
        return (self._ended or time.monotonic()) - self.began

    def stop(self) -> None:
        """Ask it to end, as Ctrl-C does; what was recorded is kept."""
        if self.code is None and self._asked_to_stop is None:
            self._asked_to_stop = time.monotonic()
            self._process.send_signal(signal.SIGINT)

    def poll(self) -> None:
        """End it if it was asked to and does not."""
        asked = self._asked_to_stop
        if asked is not None and self.code is None and time.monotonic() > asked + GRACE:
            self._process.kill()

    def close(self) -> None:
        """End it, and wait until it is gone."""
        self.stop()
        try:
            self._process.wait(GRACE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join()

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as lines:
            for line in lines:
                self._lines.append(line.rstrip("\n"))
