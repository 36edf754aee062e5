"""Every tick of a repetition, in memory."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.state import Vector

# in place of what a missing answer does not tell
NO_STATUS = -1
COLUMNS = [name for name in LOG_FIELDS if name != "measured"]


class TickLog:
    """Loses nothing."""

    def __init__(self) -> None:
        """Start with nothing."""
        self._rows: list[tuple[Any, ...]] = []
        self._lap_ends: list[int] = []

    def start(self, setting: Setting) -> None:
        """Note which axes there are."""
        self._index = setting.index
        reply = setting.controller.format.reply
        # the rows of the joints follow those of the base's six accelerations
        first = reply.slice("active").start + 6
        self._joints = slice(first, first + len(setting.controller.format.joints))
        self._wrenches = reply.slice("wrenches")
        self._unknown = np.full(reply.size, np.nan)
        self._errors = reply.slice("error")

    def tick(self, moment: Moment) -> None:
        """Note a tick."""
        tick = moment.tick
        assert tick is not None
        error, feedback = tick.error, tick.feedback
        wrenches, status = tick.reply[self._wrenches], int(tick.reply[0])
        joints = tick.reply[self._joints]
        self._note(moment, error, feedback, wrenches, joints, status, tick.compute_time, 0)

    def missed(self, moment: Moment) -> None:
        """Note a period without an answer."""
        assert moment.missed is not None
        nothing, cause = self._unknown, int(moment.missed.cause)
        error = nothing[self._errors]
        joints = np.zeros(self._joints.stop - self._joints.start)
        self._note(
            moment, error, error, nothing[self._wrenches], joints, NO_STATUS, math.nan, cause
        )

    def _note(
        self,
        moment: Moment,
        error: Vector,
        feedback: Vector,
        wrenches: Vector,
        joints: Vector,
        status: int,
        compute_time: float,
        cause: int,
    ) -> None:
        state = moment.state if moment.truth is None else moment.truth.state
        self._rows.append(
            (
                moment.time,
                moment.phase,
                moment.lap,
                moment.reference.x,
                error[self._index],
                moment.true_error,
                feedback[self._index],
                moment.feedforward,
                error,
                state.q,
                state.v,
                moment.tau,
                wrenches,
                joints,
                status,
                compute_time,
                moment.tick_time,
                cause,
            )
        )

    def lap(self, lap: Lap) -> None:
        """Note where a lap ends."""
        self._lap_ends.append(len(self._rows))

    def end(self, outcome: str) -> None:
        """Note nothing."""

    @property
    def ticks(self) -> int:
        """How many there were."""
        return len(self._rows)

    def columns(self, start: int, names: Sequence[str] = COLUMNS) -> dict[str, Vector]:
        """Give arrays by name, first axis the tick.

        Args:
            start: First tick.
            names: Which of ``COLUMNS``.
        """
        rows, places = self._rows[start:], [COLUMNS.index(name) for name in names]
        return {
            name: np.array([row[place] for row in rows], dtype=LOG_FIELDS[name].type)
            for name, place in zip(names, places, strict=True)
        }

    def log(self, first_lap: int | None) -> dict[str, Vector]:
        """Give all columns, with 'measured'.

        Args:
            first_lap: Index of the first lap that is measured; None for none.
        """
        log = self.columns(0)
        measured = np.zeros(len(self._rows), dtype=bool)
        if first_lap is not None:
            starts = [self._lap_ends[first_lap - 1]] if first_lap else [self._first_moving(log)]
            measured[starts[0] : self._lap_ends[-1]] = True
            measured &= log["missed"] == 0
        log["measured"] = measured
        return log

    def _first_moving(self, log: dict[str, Vector]) -> int:
        return int(np.argmax(log["lap"] >= 0))
