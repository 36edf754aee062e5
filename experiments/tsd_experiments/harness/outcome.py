"""What a job leaves behind: a row per run, and traces."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

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

        Args:
            label: Name of the run, unique in the outcome.
        """
        self.rows.append({"label": label, **run.summary(), **more})
        for name in TRACES:
            self.arrays[f"{label}/{name}"] = run.log[name][::TRACE_STEP].astype(np.float32)
        self.arrays[f"{label}/weights"] = run.feedforward.weights
