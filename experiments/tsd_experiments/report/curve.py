"""The signals of one run as a line of a figure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.repetition.run import Run
from tsd_casadi.state import Vector
from tsd_experiments.harness.job import Result
from tsd_experiments.harness.outcome import TRACES, signals_of

# distinct in colour and in grey
STYLES: dict[str, dict[str, Any]] = {
    "none": {"color": "#3b6fb6", "linestyle": "-"},
    "learned": {"color": "#c8352b", "linestyle": "-"},
    "reduced": {"color": "#d99a1c", "linestyle": "-"},
    "reference": {"color": "#2f7d4f", "linestyle": "--"},
    "encoded": {"color": "#6b3fa0", "linestyle": "--"},
}


@dataclass(frozen=True)
class Curve:
    """One run in a figure.

    Attributes:
        legend: What it is called there.
        signals: (N,) by name, as in a run's log, of one axis.
        peak_error: [m, rad]; None of a run that fell.
        style: Key of ``STYLES``.
        axis: 'task.axis'.
        limited: When a joint was at or past a limit, (N,) by row; see ``Run.limited``.
    """

    legend: str
    signals: Mapping[str, Vector]
    peak_error: float | None
    style: str
    axis: str = "com.z"
    limited: Mapping[str, Vector] = field(default_factory=dict)

    @classmethod
    def stored(cls, legend: str, result: Result, label: str, style: str) -> Curve:
        """Take the traces of a finished job's run along its first axis."""
        signals = {name: result.arrays[f"{label}/{name}"] for name in TRACES}
        row = result.row(label)
        axis = row["axes"][0]
        peak = row[f"peak_error_{unit_of_axis(axis)}"]
        start = f"{label}/limited/"
        limited = {
            name.removeprefix(start): values
            for name, values in result.arrays.items()
            if name.startswith(start)
        }
        return cls(legend, signals, peak, style, axis, limited)

    @classmethod
    def of(cls, legend: str, run: Run, style: str) -> Curve:
        """Take the log of a run along its first axis."""
        axis = run.axes[0]
        signals = signals_of(run, axis)
        return cls(legend, signals, run.errors[axis].peak, style, axis, run.limited)
