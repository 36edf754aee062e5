"""What a log says of its run in the end."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.repetition.run import Run
from tsd_casadi.state import Vector
from tsd_casadi.wire.run_outline import RunOutline

MEASURED = "measured_s"
KILLED = "the run was killed"


def run_summary(run: Run) -> dict[str, Any]:
    """Tell ``Run.summary`` and from when to when it is measured, as plain data for JSON."""
    times = run.log["time"][run.log["measured"]]
    measured = [float(times[0]), float(times[-1])] if times.size else None
    return {**run.summary(), MEASURED: measured}


def measured_ticks(fields: dict[str, Vector], summary: dict[str, Any]) -> NDArray[np.bool_]:
    """Find the ticks that are measured, (N,) bool.

    A run that did not come to its end is measured as one that was ended early and was
    never steady: in its last two whole laps.

    Args:
        fields: Time, lap and missed of every tick.
        summary: As of ``run_summary``, without the span where there was no end.
    """
    time, lap, answered = fields["time"], fields["lap"], fields["missed"] == 0
    if MEASURED in summary:
        span = summary[MEASURED]
        if span is None:
            return np.zeros(len(time), dtype=bool)
        return np.asarray((time >= span[0]) & (time <= span[1]) & answered)
    newest = int(lap.max(initial=-1))  # it may have been ended in the middle
    if newest < 2:
        return np.zeros(len(time), dtype=bool)
    return np.asarray((lap >= newest - 2) & (lap < newest) & answered)


def metadata_of(outline: RunOutline, summary: Mapping[str, Any]) -> dict[str, str]:
    """Say in short what a file is of, for those who list its metadata."""
    return {
        "robot": outline.robot,
        "motion": outline.motion,
        **{f"parameter {name}": f"{value:g}" for name, value in outline.parameters.items()},
        "axes": " ".join(outline.axes),
        "period_s": f"{outline.period:g}",
        "aborted": summary.get("aborted") or "",
    }
