"""The signals of one run as a line of a figure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tsd_casadi.repetition.run import Run
from tsd_casadi.state import Vector
from tsd_experiments.harness.job import Result
from tsd_experiments.harness.outcome import TRACES

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
        signals: (N,) by name, as in a run's log.
        peak_error: [m]; None of a run that fell.
        style: Key of ``STYLES``.
    """

    legend: str
    signals: Mapping[str, Vector]
    peak_error: float | None
    style: str

    @classmethod
    def stored(cls, legend: str, result: Result, label: str, style: str) -> Curve:
        """Take the traces of a finished job's run."""
        signals = {name: result.arrays[f"{label}/{name}"] for name in TRACES}
        return cls(legend, signals, result.row(label)["peak_error_m"], style)

    @classmethod
    def of(cls, legend: str, run: Run, style: str) -> Curve:
        """Take the log of a run."""
        return cls(legend, {name: run.log[name] for name in TRACES}, run.peak_error, style)
