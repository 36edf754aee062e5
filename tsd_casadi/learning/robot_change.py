r"""Evidence that the robot is another one than before: a load, a repair.

Weights that were tested before do otherwise now, or new ones leave more than was
there before them. Learning that overshoots along an axis leaves a multiple of the change
that was made there, each axis its own; what is told apart is the rest

.. math:: r = f - c \, \Delta u, \qquad c = \arg\min_{|c| \le 10} \| f - c \Delta u \|

and it is taken for another robot where

.. math:: \| r \|^2 > F s^2 + 4 (t^2 + \| f' \|^2)

with the noise s^2 of the laps and Fisher's quantile F, the tolerance t of steady laps
and the feedback f' before (zero where it is what r is the difference to).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tsd_casadi.encoding.laps import FittedLaps
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.encoding.scatter import power_of
from tsd_casadi.encoding.steadiness import EFFICIENCY, INDEPENDENT, tolerance
from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.state import Matrix, Vector

# probability that noise alone is taken for a change, in one repetition
CHANGE_LEVEL = 1e-3
# no loop answers by more than this what was fed forward
LARGEST_ANSWER = 10.0
# of the tolerance and of what was left before: one of each on either side
MARGIN = 2.0
# of a change of the feedforward: what the first repetition after it leaves, since
# friction and inertia depend on where the robot is
LEFT_BY_FIRST = 0.1


@dataclass(frozen=True)
class Observation:
    """What a repetition showed, to be compared with others.

    Attributes:
        axes: Names 'task.axis', k of them.
        basis: Of all weights.
        applied: Weights in use, (k, L).
        fitted: What the laps showed.
    """

    axes: tuple[str, ...]
    basis: PeriodicBasis
    applied: Matrix
    fitted: FittedLaps

    @property
    def needed(self) -> Matrix:
        """Weights of what the motion needed, feedforward and feedback, (k, L)."""
        return np.asarray(self.applied + self.fitted.feedback)

    def differs_from_test(self, test: Iteration) -> bool:
        """Say whether the same weights did otherwise in an earlier test."""
        if test.feedback is None:
            return False
        moved = power_of(self.fitted.feedback - test.feedback, self.basis)
        noise = self._noise() + _noise_of(test)
        return self._any_beyond(moved, noise, np.zeros_like(moved))

    def differs_from_parent(self, parent: Iteration) -> bool:
        """Say whether new weights left more than overshooting explains.

        Args:
            parent: The tested iteration that they were learned from.
        """
        if parent.feedback is None:
            return False
        change, feedback = self.applied - parent.weights, self.fitted.feedback
        size = power_of(change, self.basis)
        shared = power_of(change + feedback, self.basis) - power_of(change - feedback, self.basis)
        answer = np.divide(shared / 4, size, out=np.zeros_like(size), where=size > 0)
        answer = np.clip(answer, -LARGEST_ANSWER, LARGEST_ANSWER)
        rest = power_of(feedback - answer[:, None] * change, self.basis)
        return self._any_beyond(rest, self._noise(), power_of(parent.feedback, self.basis))

    def distance_to(self, test: Iteration) -> float:
        """Compute how far what was needed is from what an earlier test needed.

        Returns:
            Of what may be between tests of the same robot: 1 is just as far [1].
        """
        if test.feedback is None:
            return np.inf
        apart = power_of(self.needed - test.weights - test.feedback, self.basis)
        left = LEFT_BY_FIRST**2 * power_of(self.fitted.feedback, self.basis)
        allowed = self._allowed(self._noise() + _noise_of(test), left)
        return float(np.max(apart / allowed))

    def _any_beyond(self, power: Vector, noise: Vector, left: Vector) -> bool:
        return bool((power > self._allowed(noise, left)).any())

    def _allowed(self, noise: Vector, left: Vector) -> Vector:
        from scipy.special import fdtri

        laps = 2 if self.fitted.scatter is None else self.fitted.scatter.laps
        within = INDEPENDENT * EFFICIENCY * (laps - 1)
        quantile = float(fdtri(INDEPENDENT, within, 1 - CHANGE_LEVEL / len(noise)))
        size = np.sqrt(power_of(self.needed, self.basis))
        allowed = tolerance(size, [unit_of_axis(axis) for axis in self.axes])
        return np.asarray(quantile * noise + MARGIN**2 * (allowed**2 + left))

    def _noise(self) -> Vector:
        """Variance of the mean lap's feedback, (k,)."""
        scatter = self.fitted.scatter
        return np.zeros(len(self.axes)) if scatter is None else scatter.of_mean**2


def _noise_of(test: Iteration) -> Vector:
    """Compute the variance of a test's mean lap, zero if unknown, (k,)."""
    errors = (test.errors or {}).values()
    return np.array([(error.scatter or 0.0) ** 2 / (error.laps or 1) for error in errors])
