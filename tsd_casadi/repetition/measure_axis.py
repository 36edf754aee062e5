"""The measures of one axis over ticks."""

from __future__ import annotations

import math

import numpy as np

from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.state import Vector


def measure_axis(error: Vector, true_error: Vector, feedback: Vector) -> AxisError:
    """Measure how well an axis was tracked.

    Args:
        error: As the controller sees it, (N,) [m, rad].
        true_error: Of the plant itself, (N,) [m, rad]; NaN where nobody knows it.
        feedback: (N,) [m/s^2, rad/s^2].

    Returns:
        NaN without any tick.
    """
    if not error.size:
        return AxisError(math.nan)
    known = not np.isnan(true_error).any()
    return AxisError(
        rms=_rms(error),
        peak=float(np.max(np.abs(error))),
        ac_rms=_rms(error - error.mean()),
        mean_abs_feedback=float(np.mean(np.abs(feedback))),
        true_rms=_rms(true_error) if known else None,
    )


def _rms(values: Vector) -> float:
    return float(np.sqrt(np.mean(values**2)))
