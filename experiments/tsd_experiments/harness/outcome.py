"""What a job leaves behind: a row per run, and traces."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.repetition.run import Run
from tsd_casadi.state import Vector

# ticks between two samples of a stored trace
TRACE_STEP = 10
TRACES = ("time", "phase", "lap", "reference", "error", "true_error", "feedback", "feedforward")


@dataclass
class Outcome:
    """What a job leaves behind.

    Attributes:
        rows: One per run, plain data for JSON.
        arrays: Named arrays for the npz.
    """

    rows: list[dict[str, Any]] = field(default_factory=list)
    arrays: dict[str, Vector] = field(default_factory=dict)

    def add(self, label: str, run: Run, **more: Any) -> None:
        """Keep a run: its measures with further plain data, its trace and its weights.

        Traces are those of the first axis, '<label>/<name>'; those of further
        ones '<label>/<name>/<axis>'. When which limit of a joint was met is in
        '<label>/limited/<row>'.

        Args:
            label: Name of the run, unique in the outcome.
        """
        self.rows.append({"label": label, **row_of(run), **more})
        for place, axis in enumerate(run.axes):
            for name, values in signals_of(run, axis).items():
                if place == 0:
                    self.arrays[f"{label}/{name}"] = _thinned(values)
                elif run.log[name].ndim == 2:
                    self.arrays[f"{label}/{name}/{axis}"] = _thinned(values)
        for row, when in run.limited.items():
            # a sample stands for the ticks up to the next one
            starts = np.arange(0, len(when), TRACE_STEP)
            self.arrays[f"{label}/limited/{row}"] = np.logical_or.reduceat(when, starts)
        self.arrays[f"{label}/weights"] = run.feedforward.weights


def row_of(run: Run) -> dict[str, Any]:
    """Write the summary of a run as a row: its measures flat, see ``measures_of``."""
    summary = {name: value for name, value in run.summary().items() if name != "errors"}
    parameters = summary.pop("parameters")
    return {
        **summary,
        "axes": list(run.axes),
        "amplitude_m": parameters.get("amplitude"),
        "frequency_hz": run.motion.frequency,
        **{
            name: None if value is None or math.isnan(value) else value
            for name, value in measures_of(run).items()
        },
    }


def measures_of(run: Run) -> dict[str, float | None]:
    """List the measures of a run, units at the end of the names.

    Returns:
        Those of the first axis as 'rms_error_m', those of further ones as
        '<axis>/rms_error_m'.
    """
    found: dict[str, float | None] = {}
    for place, (axis, error) in enumerate(run.errors.items()):
        start, unit = f"{axis}/" if place else "", unit_of_axis(axis)
        found |= {
            f"{start}rms_error_{unit}": error.rms,
            f"{start}peak_error_{unit}": error.peak,
            f"{start}ac_rms_error_{unit}": error.ac_rms,
            f"{start}true_rms_error_{unit}": error.true_rms,
            f"{start}mean_abs_feedback": error.mean_abs_feedback,
        }
    return found


def signals_of(run: Run, axis: str) -> dict[str, Vector]:
    """Give the traces of one axis, (N,) each.

    Args:
        axis: 'task.axis'.
    """
    return {
        name: run.log[name] if run.log[name].ndim == 1 else run.along(name, axis) for name in TRACES
    }


def _thinned(values: Vector) -> Vector:
    return np.asarray(values[::TRACE_STEP], dtype=np.float32)
