r"""The learning update, as in the paper and made stable [x_fb_i-1].

.. math::

    \ddot x_{fb,i-1} = \ddot x_{fb,i-2} +
        P (x_{ref} - x_{i-1}) + D (\dot x_{ref} - \dot x_{i-1})

What the feedback had to add in one repetition is added to the feedforward of
the next. Both are linear in their weights over the same basis, so the sum is
taken there (``update_weights``).

``update_stably`` differs in three ways. It recomputes the feedback from the
position error, :math:`C e` with :math:`C = P + D s`, since a measured velocity
lags and a feedback of zero then leaves an error. It passes through the filter
of ``learning_filter``, without which lag and delay make high harmonics grow.
And it shifts what was learned from where the robot was to where it should have
been (``task_dynamics``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tsd_casadi.encoding.harmonics import (
    Harmonics,
    analyze,
    highest_harmonic,
    sample_phases,
    synthesize,
    to_harmonics,
    to_weights,
)
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.iteration import FittedRepetition
from tsd_casadi.learning.learning_filter import LearningFilter, design_filter
from tsd_casadi.learning.loop_response import estimate_response
from tsd_casadi.learning.task_dynamics import shift_to_reference
from tsd_casadi.state import Matrix, Vector

# older repetitions say little about where the robot is now; on the response all
# count, since those that hardly change any more say nothing about it
POSITION_MEMORY = 3
# the shift may make up for this share of the position feedback P e and no more,
# so that an error of zero stays the only place where learning comes to rest
LARGEST_SHIFT = 0.5


def update_weights(applied: Matrix, feedback: Matrix, gain: float = 1.0) -> Matrix:
    """Compute weights for the next repetition by the paper's rule.

    Args:
        applied: Weights that the recorded repetition used, (k, L) [m/s^2].
        feedback: What its feedback added in steady laps, fitted, (k, L) [m/s^2].
        gain: 1 is the paper's rule; smaller is more careful.

    Returns:
        applied + gain * feedback, (k, L) [m/s^2].
    """
    return np.asarray(applied + gain * feedback)


@dataclass(frozen=True)
class StableUpdate:
    """The outcome of ``update_stably``.

    Attributes:
        weights: For the next repetition, (k, L) [m/s^2].
        filters: The filter of each axis.
    """

    weights: Matrix
    filters: tuple[LearningFilter, ...]


def update_stably(
    repetitions: Sequence[FittedRepetition],
    basis: PeriodicBasis,
    frequency: float,
    P: Sequence[float],
    D: Sequence[float],
    gain: float = 1.0,
) -> StableUpdate:
    """Compute weights for the next repetition from all repetitions so far.

    Args:
        repetitions: Of one motion at the same gains, the one to go on from last.
        frequency: Laps per second [Hz].
        P: Stiffness of each axis, positive, (k,) [1/s^2].
        D: Damping of each axis, (k,) [1/s].
        gain: Share of the change that is made.

    Returns:
        The weights and the filters.
    """
    omega = angular_frequencies(basis, frequency)
    recent = repetitions[-POSITION_MEMORY:]
    u, e = _harmonics_of(recent, basis)
    x_ref = to_harmonics(basis, repetitions[-1].reference)
    filters = design_filters(repetitions, basis, frequency, P, D)
    after = np.empty_like(u[-1])
    for axis, learning_filter in enumerate(filters):
        C = np.asarray(P[axis] + 1j * omega * D[axis], dtype=complex)
        shift = _shift(u[:, axis], e[:, axis], x_ref[axis], C, omega)
        after[axis] = learning_filter.apply(u[-1, axis] + shift, C * e[-1, axis])
    weights = to_weights(basis, u[-1] + gain * (after - u[-1]))
    return StableUpdate(weights, filters)


def design_filters(
    repetitions: Sequence[FittedRepetition],
    basis: PeriodicBasis,
    frequency: float,
    P: Sequence[float],
    D: Sequence[float],
) -> tuple[LearningFilter, ...]:
    """Design the filter of each axis for the response that some repetitions show.

    Args:
        repetitions: As in ``update_stably``.
        frequency: Laps per second [Hz].
        P: Stiffness of each axis, positive, (k,) [1/s^2].
        D: Damping of each axis, (k,) [1/s].
    """
    omega = angular_frequencies(basis, frequency)
    u, e = _harmonics_of(repetitions, basis)
    return tuple(
        design_filter(
            estimate_response(u[:, axis], e[:, axis], omega, P[axis], D[axis]),
            omega,
            P[axis],
            D[axis],
        )
        for axis in range(u.shape[1])
    )


def angular_frequencies(basis: PeriodicBasis, frequency: float) -> Vector:
    """Compute the angular frequencies of the harmonics that a basis holds.

    Args:
        frequency: Laps per second [Hz].

    Returns:
        (N + 1,) [rad/s].
    """
    return np.asarray(2 * np.pi * frequency * np.arange(highest_harmonic(basis) + 1.0))


def _harmonics_of(
    repetitions: Sequence[FittedRepetition], basis: PeriodicBasis
) -> tuple[Harmonics, Harmonics]:
    """Put feedforward and error of some repetitions together, (r, k, N + 1) each."""
    return (
        np.array([to_harmonics(basis, each.weights) for each in repetitions]),
        np.array([to_harmonics(basis, each.error) for each in repetitions]),
    )


def _shift(u: Harmonics, e: Harmonics, x_ref: Harmonics, C: Harmonics, omega: Vector) -> Harmonics:
    """Compute g(x_ref) - g(x) of the newest repetition, in harmonics."""
    accelerations = synthesize(u + C * e - omega**2 * e)
    errors = synthesize(e)
    reference = synthesize(x_ref[None, :])[0]
    shift = shift_to_reference(
        sample_phases(), list(reference - errors), list(accelerations), reference
    )
    bound = LARGEST_SHIFT * C[0].real * np.abs(errors[-1])
    return analyze(np.clip(shift, -bound, bound), len(omega) - 1)
