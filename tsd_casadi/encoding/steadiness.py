"""From which lap on a repetition is steady."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tsd_casadi.encoding.laps import Lap

# two consecutive laps agree when mean and AC RMS of the feedback do, to
RELATIVE_TOLERANCE = 0.01
ABSOLUTE_TOLERANCE = 1e-4  # m/s^2


def _agree(one: Lap, other: Lap) -> bool:
    whole = one.feedback if one.feedforward is None else one.feedback + one.feedforward
    # the mean of a motion to and fro is next to nothing, and only noise
    for measure, scale in (
        (np.mean, np.sqrt(np.mean(whole**2, axis=1))),
        (np.std, np.std(whole, axis=1)),
    ):
        a = measure(one.feedback, axis=1)
        b = measure(other.feedback, axis=1)
        tolerance = np.maximum(RELATIVE_TOLERANCE * scale, ABSOLUTE_TOLERANCE)
        if not bool(np.all(np.abs(a - b) < tolerance)):
            return False
    return True


def first_steady_lap(laps: Sequence[Lap]) -> int | None:
    """Find the first lap from which on every lap agrees with the next.

    The very first one never counts: the motion begins smoothly in it.

    Args:
        laps: Whole laps in order.

    Returns:
        Its index, or None while the last two laps do not agree.
    """
    first = len(laps) - 1
    while first > 1 and _agree(laps[first - 1], laps[first]):
        first -= 1
    return first if first < len(laps) - 1 else None
