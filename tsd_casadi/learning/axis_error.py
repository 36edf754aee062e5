"""How well an axis was tracked, and how that of several axes is ranked."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class AxisError:
    """Measures of one axis over whole steady laps, in its unit: m or rad.

    Attributes:
        rms: RMS error as the controller sees it.
        peak: Largest absolute error as the controller sees it; None if unknown.
        ac_rms: RMS error without its mean; None if unknown.
        mean_abs_feedback: Mean absolute feedback [m/s^2, rad/s^2]; None if unknown.
        true_rms: RMS error of the plant itself; None where nobody knows it.
        laps: How many laps it was measured in; None if unknown.
        deviation: Standard deviation of the RMS error of a single lap; None if unknown.
        scatter: Standard deviation of the feedback from lap to lap, RMS over the
            phase [m/s^2, rad/s^2]; None if unknown. It is what does not repeat.
    """

    rms: float
    peak: float | None = None
    ac_rms: float | None = None
    mean_abs_feedback: float | None = None
    true_rms: float | None = None
    laps: int | None = None
    deviation: float | None = None
    scatter: float | None = None

    def plain(self) -> dict[str, float]:
        """Give plain data, without what is unknown."""
        return {name: value for name, value in vars(self).items() if value is not None}


def unit_of_axis(axis: str) -> str:
    """Tell the unit of an axis 'task.axis': rad for rotations, m otherwise."""
    return "rad" if axis.rpartition(".")[2].startswith("r") else "m"


def plain_errors(errors: Mapping[str, AxisError]) -> dict[str, dict[str, Any]]:
    """Give errors by axis as plain data, each with its unit."""
    return {axis: {**error.plain(), "unit": unit_of_axis(axis)} for axis, error in errors.items()}


def rank(errors: Mapping[str, AxisError], P: Sequence[float]) -> float:
    r"""Compute the one number by which iterations are ranked.

    .. math:: \sqrt{\tfrac1k \sum_j (P_j \, e_j)^2}

    with the RMS errors :math:`e_j`: stiff axes count as the feedback counts them.

    Args:
        errors: By axis, in the order of P.
        P: Stiffness of each axis, (k,) [1/s^2].

    Returns:
        [m/s^2, rad/s^2]; NaN if an error is.
    """
    # numpy would take longer for so few
    each = [(stiffness * e.rms) ** 2 for stiffness, e in zip(P, errors.values(), strict=True)]
    return math.sqrt(sum(each) / len(each))
