"""What a sweep over the stiffness tells."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np


def stiffness_for(
    rows: Sequence[dict[str, Any]], error: float, measure: str = "rms_error_m"
) -> float:
    """Find the factor on P with a given error, by interpolation in log-log.

    Beyond the sweep its last two stable points are continued.

    Args:
        rows: Of a sweep, with 'factor', the measure and 'stable'.
        error: [m].
    """
    stable = sorted(
        (row["factor"], row[measure]) for row in rows if row["stable"] and row[measure] is not None
    )
    factors, errors = np.log(np.array(stable)).T
    # the first interval that ends below the wanted error, or the last one
    below = np.flatnonzero(errors[1:] <= math.log(error))
    after = int(below[0]) + 1 if below.size else len(errors) - 1
    slope = (factors[after] - factors[after - 1]) / (errors[after] - errors[after - 1])
    return math.exp(factors[after] + slope * (math.log(error) - errors[after]))


def highest_stable(rows: Sequence[dict[str, Any]]) -> float:
    """Find the largest factor of a sweep that works."""
    return float(max(row["factor"] for row in rows if row["stable"]))


def needed(own: float, factor: float, limit: float) -> str:
    """Write a stiffness for a table, with a ! where it is only extrapolated.

    Args:
        own: P of the robot file [1/s^2].
        factor: On it.
        limit: The highest factor that works.
    """
    return f"{own * factor:.3g}" + ("" if factor <= limit else " !")


def end_of(rows: Sequence[dict[str, Any]]) -> str:
    """Tell why the least stiff run that did not work did not."""
    failed = [row for row in rows if not row["stable"]]
    if not failed:
        return "nothing in the sweep"
    first = min(failed, key=lambda row: float(row["factor"]))
    if first["fell"]:
        return "a fall"
    return ", ".join(f"{count} ticks {status}" for status, count in first["failures"].items())


def is_bounded(rows: Sequence[dict[str, Any]]) -> bool:
    """Tell whether a sweep went on until something did not work."""
    return any(not row["stable"] for row in rows)
