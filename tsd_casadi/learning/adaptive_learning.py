r"""Learning that goes by what the last change did.

As in ``iterative_learning`` the next feedforward of an axis is, harmonic by
harmonic,

.. math:: u_{i+1} = Q \, \Big(u_i + \frac{a_i}{b_i} \frac{C e_i}{T}\Big)

with Q of the response that is known of robots in general (``learning_filter``)
and T of the loop whose gain, among ``GAINS``, explains the last change best:
rotor inertia takes a share of it, the same at all frequencies. (The first change is
large and full of friction: it is not asked, and the gain is 1 there.) Friction makes the
loop answer less than that, and the less the smaller the error is; of that gain

.. math:: b_i = \frac{\Re \sum_n \overline{T \Delta u_n}\, (-C \Delta e_n)}
    {\sum_n |T \Delta u_n|^2}

is the share of the last change that arrived, over the learned harmonics. What
the first change left although that share is counted,

.. math:: r = \frac{\| C e_1 - (C e_0 - b_1 T \Delta u_1) \|}{\| C e_0 \|} ,

is taken for a share that every change leaves, since nothing tells better yet, and

.. math:: a_1 = \frac{1}{1 - r}, \qquad a_i = 1 \text{ else}

sums the geometric series (Aitken's :math:`\Delta^2`).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from tsd_casadi.encoding.harmonics import Harmonics, to_harmonics, to_weights
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.iteration import FittedRepetition
from tsd_casadi.learning.iterative_learning import angular_frequencies
from tsd_casadi.learning.learning_filter import design_filter
from tsd_casadi.learning.loop_response import LoopResponse
from tsd_casadi.state import Matrix

# of the loop: 1 for a perfect model, half of it where rotors weigh as much as links
GAINS = (1.0, 1.25, 0.85, 0.7, 0.6, 0.5, 0.4, 0.3)
# a loop that answers less than a quarter of what is expected is stuck, and one
# that answers half as much again was measured wrongly
SMALLEST_ANSWER, LARGEST_ANSWER = 0.25, 1.5
# more than half left by the first change is no geometric series
LARGEST_LEFT = 0.5


def update_adaptively(
    repetitions: Sequence[FittedRepetition],
    basis: PeriodicBasis,
    frequency: float,
    P: Sequence[float],
    D: Sequence[float],
    gain: float = 1.0,
) -> Matrix:
    """Compute the weights for the next repetition.

    Args:
        repetitions: Of one motion at the same gains, the one to go on from last.
        basis: The basis of all weights.
        frequency: Laps per second [Hz].
        P: Stiffness of each axis, positive, (k,) [1/s^2].
        D: Damping of each axis, (k,) [1/s].
        gain: Share of the change that is made.

    Returns:
        (k, L) [m/s^2, rad/s^2].
    """
    omega = angular_frequencies(basis, frequency)
    u = np.array([to_harmonics(basis, each.weights) for each in repetitions[-2:]])
    e = np.array([to_harmonics(basis, each.error) for each in repetitions[-2:]])
    after = np.empty_like(u[-1])
    for axis in range(u.shape[1]):
        C = np.asarray(P[axis] + 1j * omega * D[axis])
        usual = LoopResponse()
        Q = design_filter(usual, omega, P[axis], D[axis]).Q
        T, factor = usual.transfer(omega, P[axis], D[axis]), 1.0
        if len(repetitions) > 1:
            change, (before, now) = Q * (u[1, axis] - u[0, axis]), Q * C * e[:, axis]
            if len(repetitions) > 2:
                possible = [LoopResponse(gain).transfer(omega, P[axis], D[axis]) for gain in GAINS]
                T = min(possible, key=partial(_misfit, change, before - now))
            share = answered_share(T * change, before - now)
            factor = 1 / share
            if len(repetitions) == 2:
                factor *= anticipation(before, now - (before - share * T * change))
        after[axis] = Q * (u[-1, axis] + factor * C * e[-1, axis] / T)
    return to_weights(basis, u[-1] + gain * (after - u[-1]))


def _misfit(change: Harmonics, seen: Harmonics, T: Harmonics) -> float:
    """Compute what a response leaves unexplained of a change of the feedback [m/s^2]."""
    expected = T * change
    return float(np.linalg.norm(seen - answered_share(expected, seen) * expected))


def answered_share(expected: Harmonics, seen: Harmonics) -> float:
    """Compute b: the share of an expected change of the feedback that was seen.

    Args:
        expected: T times the change of the feedforward, (N + 1,) [m/s^2].
        seen: Minus the change of C e, (N + 1,) [m/s^2].

    Returns:
        From ``SMALLEST_ANSWER`` to ``LARGEST_ANSWER``; 1 if nothing was changed.
    """
    power = float(np.sum(np.abs(expected) ** 2))
    if power == 0.0:
        return 1.0
    share = float(np.sum((np.conj(expected) * seen).real)) / power
    return min(max(share, SMALLEST_ANSWER), LARGEST_ANSWER)


def anticipation(before: Harmonics, unexplained: Harmonics) -> float:
    """Compute a_1.

    Args:
        before: C e before the first change, (N + 1,) [m/s^2].
        unexplained: What that change left beyond what its share explains.
    """
    power = float(np.linalg.norm(before))
    left = float(np.linalg.norm(unexplained)) / power if power > 0 else 0.0
    return 1 / (1 - min(left, LARGEST_LEFT))
