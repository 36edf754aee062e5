"""What time it is, and waiting until it is another."""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """Time that only grows."""

    def now(self) -> float:
        """Tell the time [s]."""

    def sleep_until(self, moment: float) -> None:
        """Wait until a time [s], or not at all if it is over."""


class WallClock:
    """The computer's."""

    def now(self) -> float:
        """Tell the time since some moment in the past [s]."""
        return time.monotonic()

    def sleep_until(self, moment: float) -> None:
        """Wait until a time [s], or not at all if it is over."""
        left = moment - time.monotonic()
        if left > 0:
            time.sleep(left)
