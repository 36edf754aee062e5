"""The outcome of one repetition."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.motion import Motion
from tsd_casadi.state import Vector


@dataclass(frozen=True)
class Run:
    """One repetition, tick by tick, and its measures over whole steady laps.

    Attributes:
        robot: Name of the robot.
        motion: What was done.
        axes: All axes of the repetition; the first ones are learned.
        feedforward: The feedforward in use.
        gains: P and D of the learned axes.
        settings: Model error, p scale, transport, seed.
        log: One array per quantity, first axis the tick; see ``tick_log``.
        laps: The steady laps with the feedback along the learned axes.
        laps_run: All whole laps.
        steady: Whether the feedback settled; if not, the last two laps are
            measured.
        fell: Whether the robot fell, which ends the run.
        vetoes: Why the feedforward was dropped.
        failures: Ticks answered with a safe torque, by status name.
    """

    robot: str
    motion: Motion
    axes: tuple[str, ...]
    feedforward: Feedforward
    gains: dict[str, list[float]]
    settings: dict[str, Any]
    log: dict[str, Vector]
    laps: list[Lap]
    laps_run: int
    steady: bool
    fell: bool
    vetoes: list[str]
    failures: dict[str, int]

    @property
    def ticks(self) -> int:
        """Number of control ticks."""
        return len(self.log["time"])

    def along(self, name: str, axis: str) -> Vector:
        """One axis of a quantity of the log, every tick.

        Args:
            name: 'error', 'feedback', ...
            axis: 'task.axis'.
        """
        return np.asarray(self.log[name][:, self.axes.index(axis)])

    def measured(self, name: str) -> Vector:
        """A quantity in the steady laps, all axes, (N, k)."""
        return np.asarray(self.log[name][self.log["measured"]])

    @property
    def axis_errors(self) -> dict[str, dict[str, float]]:
        """The measures of every learned axis."""
        found = {}
        for place, axis in enumerate(self.feedforward.axes):
            error, true, feedback = (
                self.measured(name)[:, place] for name in ("error", "true_error", "feedback")
            )
            nothing = not len(error)
            found[axis] = {
                "rms_error": _rms(error),
                "peak_error": math.nan if nothing else float(np.max(np.abs(error))),
                "ac_rms_error": math.nan if nothing else _rms(error - error.mean()),
                "true_rms_error": _rms(true),
                "mean_abs_feedback": math.nan if nothing else float(np.mean(np.abs(feedback))),
            }
        return found

    @property
    def rank(self) -> float:
        """By which iterations are ranked: RMS over the axes of P times the RMS error."""
        errors = [each["rms_error"] for each in self.axis_errors.values()]
        return _rms(np.array(self.gains["P"]) * np.array(errors))


def _rms(values: Vector) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else math.nan
