"""The outcome of one simulated repetition."""

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
        feedforward: The feedforward in use.
        gains: Gains of the learned task, by field name.
        settings: Model error, p scale, transport, seed.
        log: One array per quantity, first axis the tick; see ``LOG_FIELDS``.
        laps: The steady laps with the feedback along the learned axis.
        laps_run: All whole laps.
        steady: Whether the feedback settled; if not, the last two laps are
            measured.
        fell: Whether the robot fell, which ends the run.
        failures: Ticks answered with a safe torque, by status name.
    """

    robot: str
    motion: Motion
    feedforward: Feedforward
    gains: dict[str, list[float]]
    settings: dict[str, Any]
    log: dict[str, Vector]
    laps: list[Lap]
    laps_run: int
    steady: bool
    fell: bool
    failures: dict[str, int]

    def __repr__(self) -> str:
        """Say what was done, with what, and how well."""
        feedforward = self.feedforward
        kind, number = feedforward.kind, feedforward.iteration
        with_what = f"{kind}, iteration {number}" if number else kind
        what = "".join(f" {name}={value:g}" for name, value in self.motion.parameters.items())
        if self.fell:
            outcome = f"fell after {self.ticks} ticks"
        else:
            outcome = f"RMS error {1e3 * self.rms_error:.4f} mm" + (
                "" if self.steady else ", never steady"
            )
        return (
            f"<Run of {self.robot}: {self.motion.name}{what}; feedforward {with_what}; {outcome}>"
        )

    @property
    def ticks(self) -> int:
        """Number of control ticks."""
        return len(self.log["time"])

    def _measured(self, name: str) -> Vector:
        return np.asarray(self.log[name][self.log["measured"]])

    @property
    def rms_error(self) -> float:
        """RMS of the error as the controller sees it [m]; NaN if nothing was measured."""
        return _rms(self._measured("error"))

    @property
    def peak_error(self) -> float:
        """Largest absolute error as the controller sees it [m]."""
        error = self._measured("error")
        return float(np.max(np.abs(error))) if error.size else math.nan

    @property
    def ac_rms_error(self) -> float:
        """RMS of the error without its mean, as the controller sees it [m]."""
        error = self._measured("error")
        return _rms(error - error.mean()) if error.size else math.nan

    @property
    def true_rms_error(self) -> float:
        """RMS of the simulated robot's own error [m]."""
        return _rms(self._measured("true_error"))

    @property
    def mean_abs_feedback(self) -> float:
        """Mean absolute feedback term [m/s^2]."""
        feedback = self._measured("feedback")
        return float(np.mean(np.abs(feedback))) if feedback.size else math.nan

    @property
    def tick_us(self) -> dict[str, float]:
        """Round trip of a tick as the client sees it [us]."""
        times = self.log["tick_us"]
        return {
            "p50": float(np.percentile(times, 50)),
            "p99": float(np.percentile(times, 99)),
            "max": float(np.max(times)),
        }

    def errors(self) -> dict[str, float]:
        """Compute the measures that a database entry keeps."""
        return {
            "rms_error_m": self.rms_error,
            "peak_error_m": self.peak_error,
            "ac_rms_error_m": self.ac_rms_error,
            "true_rms_error_m": self.true_rms_error,
            "mean_abs_feedback": self.mean_abs_feedback,
        }

    def summary(self) -> dict[str, Any]:
        """Tell everything but the log, as plain data for JSON; null where nothing was measured."""
        parameters = self.motion.parameters
        return {
            "robot": self.robot,
            "task": self.motion.name,
            "amplitude_m": parameters.get("amplitude"),
            "frequency_hz": self.motion.frequency,
            **self.settings,
            "feedforward": self.feedforward.kind,
            "iteration": self.feedforward.iteration,
            "gains": self.gains,
            **{name: None if math.isnan(x) else x for name, x in self.errors().items()},
            "steady": self.steady,
            "laps_run": self.laps_run,
            "laps_measured": len(self.laps),
            "fell": self.fell,
            "failures": self.failures,
            "ticks": self.ticks,
            "tick_us": self.tick_us,
        }


def _rms(values: Vector) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else math.nan
