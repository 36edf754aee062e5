"""Frequency and gains of the loop in which something is learned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from tsd_casadi.exceptions import InvalidValue


class FeedbackLoop(NamedTuple):
    """What the response of the loop depends on besides the robot.

    Attributes:
        frequency: Laps per second [Hz].
        P: Stiffness of each learned axis, positive, (k,) [1/s^2].
        D: Damping of each learned axis, not negative, (k,) [1/s].
    """

    frequency: float
    P: Sequence[float]
    D: Sequence[float]


def find_loop(
    axes: Sequence[str], parameters: Mapping[str, float], gains: Mapping[str, Any] | None
) -> FeedbackLoop | None:
    """Find the loop of a recording, as far as it was told.

    Without stiffness a constant error moves no feedback: nothing brings it
    back, and the response has no inverse at rest.

    Args:
        parameters: Of the motion, SI units.
        gains: Gains by field name.

    Returns:
        The loop, or None if frequency, P or D is missing or makes no sense.
    """
    frequency, P, D = parameters.get("frequency"), *((gains or {}).get(name) for name in ("P", "D"))
    if frequency is None or not 0 < frequency < np.inf:
        return None
    for values, allowed in ((P, np.greater), (D, np.greater_equal)):
        if not isinstance(values, Sequence) or len(values) != len(axes):
            return None
        if not (np.isfinite(values).all() and allowed(values, 0).all()):
            return None
    return FeedbackLoop(frequency, P, D)  # type: ignore[arg-type]


def require_loop(
    axes: Sequence[str], parameters: Mapping[str, float], gains: Mapping[str, Any]
) -> FeedbackLoop:
    """Find it where nothing can be done without.

    Args:
        parameters: Of the motion, SI units.
        gains: Gains by field name.

    Raises:
        InvalidValue: If frequency, P or D is missing or makes no sense.
    """
    loop = find_loop(axes, parameters, gains)
    if loop is None:
        raise InvalidValue(
            "frequency, P and D",
            f"{parameters.get('frequency')}, {gains.get('P')} and {gains.get('D')}",
            "for the rule 'stable' a parameter frequency [Hz], and for each of "
            f"{', '.join(axes)} a positive P and a D not below zero",
        )
    return loop
