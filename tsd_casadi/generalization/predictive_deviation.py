r"""How far a prediction may be off, from the entries left out one at a time.

The Gaussian process predicts entry i from all others without a fit of its own,
from the inverse of the covariance K of all targets y [Rasmussen and Williams,
Gaussian Processes for Machine Learning, eqs. 5.10 to 5.12]:

.. math::

    y_i - \mu_{-i} = \frac{[K^{-1} y]_i}{[K^{-1}]_{ii}}, \qquad
    \sigma_{-i}^2 = \frac{1}{[K^{-1}]_{ii}}

The process takes all weights of an axis for equally predictable. They are not: where a
joint turns round, friction makes a step that moves with the parameters. So the
standard deviation gets a scale over the phase, the RMS of the residuals
of the feedforward in units of :math:`\sigma_{-i}`; the fewer the entries, the more
it is one, what the process itself expects.
"""

from __future__ import annotations

import numpy as np

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.state import Matrix, Vector

# weight of the mean over the lap in the scale at one phase, counted in entries
POOLED_ENTRIES = 4
# weight of what the process itself expects, counted in entries
EXPECTED_ENTRIES = 1
# samples of a lap per basis function
SAMPLES = 8
# what is to be covered: two standard deviations of a normal distribution
COVERED = 2.0
POINTS = 0.954  # share of the points that these are
# of the residuals of one entry's curve, that many are independent: what each entry beyond those
# that a plane takes tells of the scale, by how often points of held-out curves lie within it.
# Without any nothing tells it: three, the least with which Student's distribution has a standard
# deviation at all
INDEPENDENT = 2
LEAST_FREEDOM = 3
# whole curves differ in how far off they are, some places are harder than others: their
# magnitudes are as widely spread as if they had been estimated from so few numbers
CURVES_FREEDOM = 4
# share of whole laps that the simultaneous band is meant to hold
WHOLE_LAPS = 0.95


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


def deviation_scale(basis: PeriodicBasis, residuals: Matrix, parameters: int) -> Matrix:
    """Compute what the predicted standard deviation is multiplied with, over the phase.

    Args:
        residuals: Residuals of the weights in units of their predicted standard
            deviation, (n, k, L).
        parameters: Number of them, d.

    Returns:
        Weights of the scale in that basis, (k, L): RMS of the residuals at each
        phase, drawn towards the RMS over the lap and towards one, times the
        quantile of Student's distribution for so few entries. One and that where
        a plane takes all entries: without one of them nothing is predicted.
    """
    n = len(residuals)
    if n <= parameters + 1:
        return np.full(residuals.shape[1:], student_factor(n, parameters))
    values = basis.values(lap(basis))
    square = np.mean((residuals @ values.T) ** 2, axis=0)
    pooled = square.mean(axis=1, keepdims=True)
    square = n * square + POOLED_ENTRIES * pooled + EXPECTED_ENTRIES
    square /= n + POOLED_ENTRIES + EXPECTED_ENTRIES
    # the mean under each bump is that bump's weight
    square = square @ (values / values.sum(axis=0))
    return np.asarray(student_factor(n, parameters) * np.sqrt(square))


def band_factor(basis: PeriodicBasis, residuals: Matrix, scale: Matrix, parameters: int) -> Vector:
    """Compute how many standard deviations hold whole laps.

    As many phases as the basis resolves, half its functions, may each leave the band
    (Bonferroni, with Student's distribution). Where the residuals of whole laps went
    farther than that, the band goes as far as they did: a new lap is within the
    largest of n with n chances of n + 1.

    Args:
        residuals: As for ``deviation_scale``.
        scale: What it gave.
        parameters: Number of them, d.

    Returns:
        For each axis, (k,).
    """
    from scipy.stats import t  # takes half a second

    n = len(residuals)
    chance = (1 - WHOLE_LAPS) / (basis.L / 2)
    freedom = min(_freedom(n, parameters), CURVES_FREEDOM)
    expected = float(t.ppf(1 - chance / 2, freedom)) / student_factor(n, parameters)
    values = basis.values(lap(basis))
    farthest = np.max(np.abs(residuals @ values.T) / (scale @ values.T), axis=2)
    rank = min(int(np.ceil(WHOLE_LAPS * (n + 1))), n)
    return np.asarray(np.maximum(np.sort(farthest, axis=0)[rank - 1], expected))


def student_factor(entries: int, parameters: int, deviations: float = COVERED) -> float:
    """Compute by how much a standard deviation from few entries has to be larger.

    Args:
        entries: Their number, one more than there are parameters at least.
        parameters: Number of them.
        deviations: How many of them are to be as improbable as of a normal distribution.
    """
    from scipy.stats import norm, t  # takes half a second

    return float(t.isf(norm.sf(deviations), _freedom(entries, parameters)) / deviations)


def _freedom(entries: int, parameters: int) -> int:
    """Count the independent numbers that the scale is the mean of."""
    # fewer than a plane takes are left where entries that disagree were taken out
    return LEAST_FREEDOM + INDEPENDENT * max(0, entries - parameters - 1)
