"""What a repetition leaves behind while it goes on: its ticks, and which of them are laps."""

from __future__ import annotations

from typing import Any

import numpy as np

from tsd_casadi.encoding.laps import Lap, first_steady_lap
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.state import Vector

# what a tick leaves behind; which ticks are measured is known in the end only
COLUMNS = [name for name in LOG_FIELDS if name != "measured"]
LAP_COLUMNS = [COLUMNS.index(name) for name in ("phase", "feedback", "error", "reference")]


class TickLog:
    """Ticks in order, and whole laps of them.

    Attributes:
        laps: All whole laps so far.
    """

    def __init__(self) -> None:
        """Start with nothing."""
        self.laps: list[Lap] = []
        self._starts: list[int] = []
        self._rows: list[tuple[Any, ...]] = []

    def __len__(self) -> int:
        """Count the ticks."""
        return len(self._rows)

    def add(self, *quantities: Any) -> None:
        """Keep one tick: its quantities in the order of ``COLUMNS``."""
        self._rows.append(quantities)

    def add_lap(self, start: int) -> None:
        """Take the ticks from number ``start`` on as a whole lap."""
        columns = (np.array([row[column] for row in self._rows[start:]]) for column in LAP_COLUMNS)
        phase, *rows = columns
        feedback, error, wanted = (values[None, :] for values in rows)
        self._starts.append(start)
        self.laps.append(Lap(phase, feedback, error, wanted))

    def measured_laps(self) -> tuple[int, list[Lap]]:
        """Choose the laps that are measured: the steady ones, else the last two.

        Returns:
            Number of their first tick, and the laps; none where there are less than two.
        """
        if len(self.laps) < 2:
            return len(self), []
        first = first_steady_lap(self.laps)
        first = len(self.laps) - 2 if first is None else first
        return self._starts[first], self.laps[first:]

    def arrays(self, measured_from: int) -> dict[str, Vector]:
        """Put all ticks together, one array per quantity.

        Args:
            measured_from: Number of the first measured tick.
        """
        log = {
            name: np.array([row[column] for row in self._rows], dtype=LOG_FIELDS[name].type)
            for column, name in enumerate(COLUMNS)
        }
        log["measured"] = np.arange(len(self)) >= measured_from
        return log
