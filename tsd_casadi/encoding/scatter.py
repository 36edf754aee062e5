r"""What does not repeat from lap to lap, told from the differences of consecutive laps.

With :math:`f_1 \dots f_M` the fitted signals of M laps,

.. math:: s^2 = \frac{1}{2 (M - 1)} \sum_{m=2}^{M} \| f_m - f_{m-1} \|^2

estimates the variance of a lap without being misled by a slow drift (von Neumann,
Ann. Math. Stat. 12, 1941); their mean has the variance s^2 / M.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tsd_casadi.encoding.harmonics import sampled_values
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.state import Matrix, Vector


@dataclass(frozen=True)
class Scatter:
    """Of some laps of one repetition.

    Attributes:
        laps: M, at least 2.
        signal: Standard deviation of a lap's signal, RMS over the phase, (k,), in
            the signals' unit.
        weights: That of a lap's weights, RMS over all of an axis, (k,), in the same
            unit. Noise that is spread over all harmonics is larger there, since
            neighbouring bumps overlap.
    """

    laps: int
    signal: Vector
    weights: Vector

    @property
    def of_mean(self) -> Vector:
        """Standard deviation of the mean lap's signal, RMS over the phase, (k,)."""
        return np.asarray(self.signal / np.sqrt(self.laps))

    def uncertainty(self, L: int) -> Matrix:
        """Compute the standard deviation of each weight of the mean lap.

        The same for all weights of an axis: a few laps do not tell where in a lap
        it is larger.

        Returns:
            (k, L).
        """
        return np.repeat((self.weights / np.sqrt(self.laps))[:, None], L, axis=1)


def scatter_of(fitted: Sequence[Matrix], basis: PeriodicBasis) -> Scatter:
    """Compute it from the weights of each lap.

    Args:
        fitted: In order, (k, L) each, at least two.
    """
    changes = np.diff(np.asarray(fitted), axis=0)
    count = len(fitted)
    return Scatter(
        laps=count,
        signal=np.sqrt(power_of(changes, basis).sum(axis=0) / (2 * (count - 1))),
        weights=np.sqrt(np.mean(changes**2, axis=2).sum(axis=0) / (2 * (count - 1))),
    )


def power_of(weights: Matrix, basis: PeriodicBasis) -> Vector:
    """Compute the mean square over the phase of signals with some weights.

    Args:
        weights: (..., L).

    Returns:
        (...), in the square of their unit.
    """
    return np.asarray(np.mean((weights @ sampled_values(basis).T) ** 2, axis=-1))
