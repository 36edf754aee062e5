"""Every tick of a repetition, in memory."""

from __future__ import annotations

from typing import Any

import numpy as np

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_casadi.state import Vector

# name: unit and meaning; (k,) is along the axes of the repetition
COLUMNS = {
    "time": "s",
    "phase": "rad",
    "lap": "1, -1 while holding",
    "reference": "m, rad, (k,), relative to the middle",
    "error": "m, rad, (k,), as the controller sees it",
    "true_error": "m, rad, (k,), of the robot itself; NaN where nobody knows it",
    "feedback": "m/s^2, rad/s^2, (k,)",
    "feedforward": "m/s^2, rad/s^2, (k,)",
    "all_errors": "m, rad, all axes of all tasks",
    "q": "Pinocchio's convention",
    "v": "Pinocchio's convention",
    "tau": "N m",
    "wrenches": "N, N m, sole frames",
    "status": "0 ok",
    "compute_us": "us, inside the compiled function",
    "tick_us": "us, round trip as the client sees it",
}
MEASURED = "whether the tick is in a steady lap"
SINGLE_PRECISION = ("all_errors", "q", "v", "tau", "wrenches")


class TickLog:
    """Loses nothing."""

    def __init__(self) -> None:
        """Start with nothing."""
        self._rows: list[tuple[Any, ...]] = []
        self._lap_ends: list[int] = []

    def start(self, setting: Setting) -> None:
        """Note which axes there are."""
        self._index = setting.index
        self._wrenches = setting.controller.format.reply.slice("wrenches")

    def tick(self, moment: Moment) -> None:
        """Note a tick."""
        tick, state = moment.tick, moment.state if moment.truth is None else moment.truth.state
        assert tick is not None
        error = tick.error
        self._rows.append(
            (
                moment.time,
                moment.phase,
                moment.lap,
                moment.reference.x,
                error[self._index],
                moment.true_error,
                tick.feedback[self._index],
                moment.feedforward,
                error,
                state.q,
                state.v,
                moment.tau,
                tick.reply[self._wrenches],
                int(tick.reply[0]),
                tick.compute_time,
                moment.tick_time,
            )
        )

    def lap(self, lap: Lap) -> None:
        """Note where a lap ends."""
        self._lap_ends.append(len(self._rows))

    def end(self, outcome: str) -> None:
        """Nothing to note."""

    @property
    def ticks(self) -> int:
        """How many there were."""
        return len(self._rows)

    def columns(self, start: int, end: int | None = None) -> dict[str, Vector]:
        """Arrays by name, first axis the tick, see ``COLUMNS``.

        Args:
            start: First tick.
            end: One after the last; all to the end by default.
        """
        rows = self._rows[start:end]
        return {
            name: np.array([row[column] for row in rows]) for column, name in enumerate(COLUMNS)
        }

    def log(self, first_lap: int | None) -> dict[str, Vector]:
        """All columns, with 'measured'.

        Args:
            first_lap: Index of the first lap that is measured; None for none.
        """
        log = self.columns(0)
        measured = np.zeros(len(self._rows), dtype=bool)
        if first_lap is not None:
            starts = [self._lap_ends[first_lap - 1]] if first_lap else [self._first_moving(log)]
            measured[starts[0] : self._lap_ends[-1]] = True
        log["measured"] = measured
        for name in SINGLE_PRECISION:
            log[name] = log[name].astype(np.float32)
        return log

    def _first_moving(self, log: dict[str, Vector]) -> int:
        return int(np.argmax(log["lap"] >= 0))
