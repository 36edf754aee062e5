r"""Periodic signals as a weighted sum of bumps over the phase [basis_functions, psi].

.. math::

    f(\phi) = \frac{\sum_j w_j \Gamma_j(\phi)}{\sum_j \Gamma_j(\phi)},
    \qquad \Gamma_j(\phi) = \exp(h (\cos(\phi - c_j) - 1))

[basis_functions] and [psi], with L centres :math:`c_j = 2 \pi j / L` and one
width h for all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.state import Matrix, Vector

L_DEFAULT = 25
# h = 2.5 L: neighbouring bumps cross at two thirds of their height
WIDTH_PER_CENTER = 2.5
# of the mean squared basis value: keeps the fit defined where samples are few
RIDGE = 1e-9


@dataclass(frozen=True)
class PeriodicBasis:
    """L normalised periodic radial basis functions.

    Attributes:
        L: Number of functions.
        width: h.
    """

    L: int = L_DEFAULT
    width: float = WIDTH_PER_CENTER * L_DEFAULT

    def __post_init__(self) -> None:
        """Check the sizes."""
        if self.L < 1:
            raise InvalidValue("L", self.L, "at least 1 basis function")
        if not 0 < self.width < 1e6:
            raise InvalidValue("width", self.width, "a positive number")

    @classmethod
    def of_size(cls, L: int) -> PeriodicBasis:
        """Make the basis of L functions with the usual width 2.5 L."""
        return cls(L, WIDTH_PER_CENTER * L)

    @property
    def centers(self) -> Vector:
        """c_j, (L,) [rad]."""
        return 2 * np.pi * np.arange(self.L) / self.L

    def values(self, phase: ArrayLike) -> Matrix:
        r"""Compute the normalised functions :math:`\Gamma_j / \sum_i \Gamma_i`.

        Args:
            phase: (N,) [rad], wrapped or not.

        Returns:
            (N, L), every row sums to one.
        """
        phases = np.atleast_1d(np.asarray(phase, dtype=float))
        exponent = self.width * (np.cos(phases[:, None] - self.centers) - 1)
        # the largest exponent taken out: no underflow, however narrow the bumps
        gamma = np.exp(exponent - exponent.max(axis=1, keepdims=True))
        return np.asarray(gamma / gamma.sum(axis=1, keepdims=True))

    def evaluate(self, phase: ArrayLike, weights: ArrayLike) -> Matrix:
        """Compute the signals at some phases.

        Args:
            phase: (N,) [rad].
            weights: (k, L), one row per signal.

        Returns:
            (k, N), in the weights' unit.
        """
        return np.asarray(np.atleast_2d(weights) @ self.values(phase).T)

    def fit(self, phase: ArrayLike, signals: ArrayLike) -> Matrix:
        """Fit weights by ridge least squares over all samples.

        Args:
            phase: (N,) [rad].
            signals: (k, N), or a stack of them, (..., k, N).

        Returns:
            (k, L) or (..., k, L), in the signals' unit.
        """
        values = self.values(phase)
        gram = values.T @ values
        gram += RIDGE * np.trace(gram) / self.L * np.eye(self.L)
        projected = values.T @ np.atleast_2d(np.asarray(signals, dtype=float)).swapaxes(-1, -2)
        return np.asarray(np.linalg.solve(gram, projected).swapaxes(-1, -2))
