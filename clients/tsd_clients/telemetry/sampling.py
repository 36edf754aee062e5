"""Which ticks of a run are seen, and what is told of those in between."""

from __future__ import annotations

from time import perf_counter

import numpy as np

from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_casadi.repetition.tick_row import TickRow
from tsd_casadi.state import Vector
from tsd_casadi.wire.telemetry_rows import telemetry_layout

# of the clock, whatever time passes in the simulation: nobody sees more [s]
SPACING = 0.01


class Sampling:
    """Takes a row of a tick now and then, by the clock.

    Attributes:
        layout: What the numbers of a row are.
    """

    def __init__(self, setting: Setting, spacing: float = SPACING) -> None:
        """Sample a repetition that is about to begin.

        Args:
            spacing: Least time between two rows by the clock [s].
        """
        self._row = TickRow(setting)
        self.layout = telemetry_layout(self._row.layout)
        self._spacing = spacing
        self._due = 0.0
        self._round_trips: list[float] = []
        self._missed = 0

    def take(self, moment: Moment) -> Vector | None:
        """Count a tick that was answered or missed.

        Returns:
            Its row (layout.size,), if it is to be seen.
        """
        self._round_trips.append(moment.tick_time)
        if moment.missed is not None:
            self._missed += 1
        now = perf_counter()
        if now < self._due:
            return None
        self._due = now + self._spacing
        times = sorted(self._round_trips)
        since = (len(times), self._missed, times[len(times) // 2], times[-1])
        self._round_trips.clear()
        self._missed = 0
        return np.concatenate((self._row.of(moment), since))
