"""Methods to compare with that are what they are, whatever the entries say."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations_with_replacement

import numpy as np

from tsd_casadi.state import Matrix

# (learned places, their weights, asked places) -> weights
Method = Callable[[Matrix, Matrix, Matrix], Matrix]
# of the single process: share of the variance that is noise
NOISE = 1e-4


def interpolate_linearly(places: Matrix, weights: Matrix, asked: Matrix) -> Matrix:
    """Interpolate in the simplices between the entries; outside them the nearest entry's."""
    from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

    low, span = places.min(axis=0), np.ptp(places, axis=0)
    known, wanted = (places - low) / span, (asked - low) / span
    if places.shape[1] == 1:
        order = np.argsort(known[:, 0])
        columns = [np.interp(wanted[:, 0], known[order, 0], each) for each in weights[order].T]
        return np.stack(columns, axis=1)
    found = np.asarray(LinearNDInterpolator(known, weights)(wanted))
    outside = np.isnan(found).any(axis=1)
    if outside.any():
        found[outside] = NearestNDInterpolator(known, weights)(wanted[outside])
    return found


def fit_quadratic(places: Matrix, weights: Matrix, asked: Matrix) -> Matrix:
    """Fit a polynomial of second degree; the smallest one where the entries leave it open."""
    low, span = places.min(axis=0), np.ptp(places, axis=0)

    def monomials(at: Matrix) -> Matrix:
        x = np.column_stack([np.ones(len(at)), 2 * (at - low) / span - 1])
        pairs = combinations_with_replacement(range(x.shape[1]), 2)
        return np.stack([x[:, i] * x[:, j] for i, j in pairs], axis=1)

    return np.asarray(monomials(asked) @ np.linalg.lstsq(monomials(places), weights, rcond=1e-8)[0])


def predict_by_one_process(places: Matrix, weights: Matrix, asked: Matrix) -> Matrix:
    """Predict by a Matern 5/2 process about the mean, with a little noise."""
    import warnings

    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    low, span = places.min(axis=0), np.ptp(places, axis=0)
    mean = weights.mean(axis=0)
    spread = np.sqrt(np.mean(weights.var(axis=0)))
    smooth = Matern(np.ones(places.shape[1]), (0.1, 100.0), nu=2.5)
    kernel = ConstantKernel(1.0, (1e-2, 1e3)) * smooth + WhiteKernel(NOISE, "fixed")
    process = GaussianProcessRegressor(kernel, alpha=0.0, n_restarts_optimizer=2, random_state=0)
    with warnings.catch_warnings():
        # a bound that is met is a sensible answer for a few entries
        warnings.simplefilter("ignore", ConvergenceWarning)
        process.fit((places - low) / span, (weights - mean) / spread)
    return np.asarray(mean + spread * process.predict((asked - low) / span))


FIXED: dict[str, Method] = {
    "linear": interpolate_linearly,
    "quadratic": fit_quadratic,
    "one process": predict_by_one_process,
}
