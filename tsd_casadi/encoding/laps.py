"""Whole laps of a repetition, and which of them are steady."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.state import Matrix, Vector

# two consecutive laps agree when mean and AC RMS of the feedback do, to
RELATIVE_TOLERANCE = 0.01
ABSOLUTE_TOLERANCE = 1e-4  # m/s^2


@dataclass(frozen=True)
class Lap:
    """One whole lap.

    Attributes:
        phase: (N,) [rad].
        feedback: Feedback term along the learned axes, (k, N) [m/s^2].
        error: Position error x_ref - x there, (k, N) [m]; None if it was not
            recorded, which is enough for the paper's rule.
        reference: x_ref, (k, N) [m]; None together with the error.
        feedforward: What was fed forward, (k, N) [m/s^2]; None for none.
    """

    phase: Vector
    feedback: Matrix
    error: Matrix | None = None
    reference: Matrix | None = None
    feedforward: Matrix | None = None


@dataclass(frozen=True)
class FittedLaps:
    """What some laps have in common, as weights of a basis.

    Attributes:
        feedback: (k, L) [m/s^2].
        error: (k, L) [m]; None unless every lap has error and reference.
        reference: (k, L) [m]; None together with the error.
    """

    feedback: Matrix
    error: Matrix | None = None
    reference: Matrix | None = None


def join_laps(laps: Sequence[Lap]) -> Lap:
    """Put the samples of some laps together as those of one.

    Args:
        laps: At least one.

    Returns:
        All samples in order; without error and reference if a lap lacks one.
    """
    phase = np.concatenate([lap.phase for lap in laps])
    feedback = np.concatenate([lap.feedback for lap in laps], axis=1)
    errors = [lap.error for lap in laps if lap.error is not None]
    references = [lap.reference for lap in laps if lap.reference is not None]
    if len(errors) < len(laps) or len(references) < len(laps):
        return Lap(phase, feedback)
    return Lap(phase, feedback, np.concatenate(errors, axis=1), np.concatenate(references, axis=1))


def fit_laps(laps: Sequence[Lap], basis: PeriodicBasis) -> FittedLaps:
    """Fit everything that some laps recorded, at least one of them, at once."""
    joined = join_laps(laps)
    known = [joined.feedback, joined.error, joined.reference]
    signals = [signal for signal in known if signal is not None]
    return FittedLaps(*basis.fit(joined.phase, np.stack(signals)))


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
