r"""How far a prediction may be off, from the entries left out one at a time.

The Gaussian process predicts entry i from all others without a fit of its own,
from the inverse of the covariance K of all targets y [Rasmussen and Williams,
Gaussian Processes for Machine Learning, eqs. 5.10 to 5.12]:

.. math::

    y_i - \mu_{-i} = \frac{[K^{-1} y]_i}{[K^{-1}]_{ii}}, \qquad
    \sigma_{-i}^2 = \frac{1}{[K^{-1}]_{ii}}

The process takes all weights for equally predictable. They are not: where a
joint turns round, friction makes a step that moves with the parameters.
So the standard deviation gets a scale over the phase, the RMS of the residuals
of the feedforward in units of :math:`\sigma_{-i}`.
"""

from __future__ import annotations

import numpy as np

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.state import Matrix, Vector

# weight of the mean over the lap in the scale at one phase, counted in entries
POOLED_ENTRIES = 4
# samples of a lap per basis function
SAMPLES = 8
# what is to be covered: two standard deviations of a normal distribution
COVERED = 2.0


def leave_one_out(covariance: Matrix, targets: Matrix) -> tuple[Matrix, Vector]:
    """Predict each target from the others: residuals and standard deviations.

    Args:
        covariance: K, noise included, (n, n).
        targets: y, (n, m).

    Returns:
        Residuals y_i - mu_-i, (n, m), and sigma_-i, (n,).
    """
    inverse = np.linalg.inv(covariance)
    variances = 1 / np.diag(inverse)
    return variances[:, None] * (inverse @ targets), np.sqrt(variances)


def lap(basis: PeriodicBasis) -> Vector:
    """Sample the phases of a lap densely for a basis, (N,) [rad]."""
    count = SAMPLES * basis.L
    return np.asarray(2 * np.pi * np.arange(count) / count)


def deviation_scale(basis: PeriodicBasis, residuals: Matrix) -> Matrix:
    """Compute what a standard deviation of one is multiplied with, over the phase.

    Args:
        residuals: Residuals of the weights in units of their predicted standard
            deviation, (n, k, L).

    Returns:
        Weights of the scale in that basis, (k, L), in the unit of the weights:
        RMS of the residuals at each phase, drawn towards the RMS over the lap,
        times the quantile of Student's distribution for so few entries.
    """
    n = len(residuals)
    values = basis.values(lap(basis))
    square = np.mean((residuals @ values.T) ** 2, axis=0)
    pooled = square.mean(axis=1, keepdims=True)
    square = (n * square + POOLED_ENTRIES * pooled) / (n + POOLED_ENTRIES)
    # the mean under each bump is that bump's weight
    square = square @ (values / values.sum(axis=0))
    return np.asarray(student_factor(n) * np.sqrt(square))


def student_factor(entries: int) -> float:
    """Compute by how much a standard deviation from few entries has to be larger.

    Args:
        entries: Their number, at least two.
    """
    from scipy.stats import norm, t  # takes half a second

    return float(t.ppf(norm.cdf(COVERED), entries - 1) / COVERED)
