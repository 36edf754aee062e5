"""Errors of a repetition, with what its laps tell about how well they repeat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.scatter import Scatter
from tsd_casadi.learning.axis_error import AxisError


def with_scatter(
    errors: dict[str, AxisError], laps: Sequence[Lap], scatter: Scatter | None
) -> dict[str, AxisError]:
    """Note how many laps there were, and how far one is from the others.

    Args:
        errors: By axis, k of them.
        laps: The steady laps that they were measured in.
        scatter: Of the laps' feedback; None for a single lap.

    Returns:
        The same errors, with what can be told.
    """
    each = [_rms_errors(lap) for lap in laps]
    known = [error for error in each if error is not None]
    deviations = (
        np.std(known, axis=0, ddof=1).tolist()
        if len(known) == len(laps) > 1
        else [None] * len(errors)
    )
    scatters = [None] * len(errors) if scatter is None else scatter.signal.tolist()
    return {
        axis: replace(error, laps=len(laps), deviation=deviation, scatter=spread)
        for (axis, error), deviation, spread in zip(
            errors.items(), deviations, scatters, strict=True
        )
    }


def _rms_errors(lap: Lap) -> list[float] | None:
    if lap.error is None:
        return None
    return np.sqrt(np.mean(lap.error**2, axis=1)).tolist()  # type: ignore[no-any-return]
