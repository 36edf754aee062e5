"""The outcome of one repetition."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.learning.axis_error import AxisError, rank, unit_of_axis
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.measure_axis import measure_axis
from tsd_casadi.state import Vector
from tsd_casadi.tick.row_state import AT_LIMIT, JOINT_ROW, name_row


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
        log: One array per quantity, first axis the tick; see ``LOG_FIELDS``.
        laps: The steady laps with the feedback along the learned axes.
        laps_run: All whole laps.
        steady: Whether the feedback settled; if not, the last two laps are
            measured.
        fell: Whether the robot fell, which ends the run.
        vetoes: Why the feedforward was dropped.
        remarks: What else compensators have to say of the repetition.
        failures: Ticks answered with a safe torque, by status name.
        at_limits: Ticks at or past a limit of position or velocity, by joint.
        missed: Periods without an answer, stepped with the fallback, by cause.
        aborted: What ended it early; empty for nothing. A fall is told by ``fell``.
        model: Fingerprint of the robot's files; empty where nobody knows.
        infeasible_request: State and command of the first tick without a solution;
            None if there was none.
        conflict: By how much each row of a set that cannot hold together there would have
            to give way alone, by name; see ``Tick.conflict``.
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
    missed: dict[str, int] = field(default_factory=dict)
    aborted: str = ""
    model: str = ""
    infeasible_request: Vector | None = None
    at_limits: dict[str, int] = field(default_factory=dict)
    conflict: dict[str, float] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def __repr__(self) -> str:
        """Say what was done, with what, and how well."""
        feedforward = self.feedforward
        kind, number = feedforward.kind, feedforward.iteration
        with_what = f"{kind}, iteration {number}" if number else kind
        what = "".join(f" {name}={value:g}" for name, value in self.motion.parameters.items())
        if self.fell:
            outcome = f"fell after {self.ticks} ticks"
        elif self.aborted:
            outcome = f"aborted after {self.ticks} ticks"
        else:
            outcome = ", ".join(
                f"{axis} {1e3 * error.rms:.4f} m{unit_of_axis(axis)}"
                for axis, error in self.errors.items()
            ) + ("" if self.steady else ", never steady")
        return (
            f"<Run of {self.robot}: {self.motion.name}{what}; feedforward {with_what}; {outcome}>"
        )

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
        """Pick a quantity in the steady laps, all axes, (N, k)."""
        return np.asarray(self.log[name][self.log["measured"]])

    @property
    def limited(self) -> dict[str, Vector]:
        """When joints were at or past limits of position or velocity, (N,) each.

        By row, named as in ``Tick.active``; a row that yielded has its own name.
        """
        if not self.at_limits:
            return {}
        states = np.abs(self.log["joint_limits"])
        columns = np.flatnonzero(np.isin(states, AT_LIMIT).any(axis=0))
        found: dict[str, Vector] = {}
        for joint, column in zip(self.at_limits, columns, strict=True):
            for state in AT_LIMIT:
                name, when = name_row(f"{JOINT_ROW}.{joint}", state), states[:, column] == state
                if when.any():
                    found[name] = found.get(name, when) | when
        return found

    @property
    def learned(self) -> tuple[str, ...]:
        """The axes that are learned."""
        return self.feedforward.axes

    @property
    def errors(self) -> dict[str, AxisError]:
        """The measures of every learned axis; NaN where nothing was measured."""
        columns = {name: self.measured(name) for name in ("error", "true_error", "feedback")}
        return {
            axis: measure_axis(*(values[:, place] for values in columns.values()))
            for place, axis in enumerate(self.learned)
        }

    @property
    def rank(self) -> float:
        """By which iterations are ranked [m/s^2, rad/s^2]; see ``rank``."""
        return rank(self.errors, self.gains["P"])

    @property
    def tick_us(self) -> dict[str, float]:
        """Round trip of an answered tick as the client sees it [us]; NaN if none was answered."""
        times = self.log["tick_us"][self.log["missed"] == 0]
        if not times.size:
            return dict.fromkeys(("p50", "p99", "max"), math.nan)
        return {
            "p50": float(np.percentile(times, 50)),
            "p99": float(np.percentile(times, 99)),
            "max": float(np.max(times)),
        }

    def summary(self) -> dict[str, Any]:
        """Tell everything but the log, as plain data for JSON; null where nothing was measured."""
        return {
            "robot": self.robot,
            "motion": self.motion.name,
            "parameters": self.motion.parameters,
            **self.settings,
            "feedforward": self.feedforward.kind,
            "iteration": self.feedforward.iteration,
            "gains": self.gains,
            "errors": {
                axis: {
                    "unit": unit_of_axis(axis),
                    **{
                        name: None if value is None or math.isnan(value) else value
                        for name, value in asdict(error).items()
                    },
                }
                for axis, error in self.errors.items()
            },
            "rank": None if math.isnan(self.rank) else self.rank,
            "steady": self.steady,
            "laps_run": self.laps_run,
            "laps_measured": len(self.laps),
            "fell": self.fell,
            "fell_at": float(self.log["time"][-1]) if self.fell else None,
            "failures": self.failures,
            "at_limits": self.at_limits,
            "missed": self.missed,
            "aborted": self.aborted or None,
            "vetoes": self.vetoes,
            "remarks": self.remarks,
            "ticks": self.ticks,
            "tick_us": {
                name: None if math.isnan(value) else value for name, value in self.tick_us.items()
            },
        }
