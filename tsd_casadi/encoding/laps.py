"""Whole laps of a repetition, and what they have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.encoding.scatter import Scatter, scatter_of
from tsd_casadi.state import Matrix, Vector


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

    def along(self, order: Sequence[int]) -> Lap:
        """Take the rows of all signals in another order."""
        known = (self.feedback, self.error, self.reference, self.feedforward)
        feedback, *others = (None if each is None else each[list(order)] for each in known)
        assert feedback is not None
        return Lap(self.phase, feedback, *others)


@dataclass(frozen=True)
class FittedLaps:
    """What some laps have in common, as weights of a basis.

    Attributes:
        feedback: (k, L) [m/s^2].
        error: (k, L) [m]; None unless every lap has error and reference.
        reference: (k, L) [m]; None together with the error.
        scatter: How far the feedback of one lap is from that of the others; None
            for a single lap.
    """

    feedback: Matrix
    error: Matrix | None = None
    reference: Matrix | None = None
    scatter: Scatter | None = None


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
    fitted = FittedLaps(*basis.fit(joined.phase, np.stack(signals)))
    if len(laps) == 1:
        return fitted
    each = [basis.fit(lap.phase, lap.feedback) for lap in laps]
    return replace(fitted, scatter=scatter_of(each, basis))
