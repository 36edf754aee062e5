r"""Required acceleration as a function of where the task is.

A repetition with an error e has been elsewhere than its reference: what its
feedback and feedforward had to add belongs to x = x_ref - e. At low gains the
two differ by centimetres, and simply summing learns the wrong place. From the
newest repetitions of a motion,

.. math:: a_i(\phi) = u_i + C e_i + \ddot e_i = g(x_i(\phi)) + p(\phi) + \epsilon,

with Gaussian process priors on g (smooth in position) and p (periodic in
phase). Shifting what was learned last from where it was to where it should be
adds g(x_ref) - g(x_i). Scales are fitted by marginal likelihood with broad
priors (Rasmussen and Williams, section 5.4); kernels add as in their
section 4.2.4.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tsd_casadi.state import Matrix, Vector

# over which g bends, and over which p does
POSITION_SCALE = 0.1  # m
PHASE_SCALE = 0.7  # rad
# magnitudes of g, p and noise [m/s^2]: medians of their log-normal priors, and
# the priors' standard deviations
MEDIANS = np.array([0.5, 0.03, 0.01])
DEVIATIONS = np.array([1.0, 0.7, 1.0])
# samples of a lap that take part
EVERY = 5


def shift_to_reference(
    phases: Vector, positions: Sequence[Vector], accelerations: Sequence[Vector], reference: Vector
) -> Vector:
    """Compute g(x_ref) - g(x) of the newest repetition.

    Args:
        phases: The sampled phases, (M,) [rad].
        positions: x of each repetition, the newest last, (M,) each [m].
        accelerations: a of each repetition, (M,) each [m/s^2].
        reference: x_ref, (M,) [m].

    Returns:
        (M,) [m/s^2].
    """
    x = np.concatenate([position[::EVERY] for position in positions])
    a = np.concatenate([acceleration[::EVERY] for acceleration in accelerations])
    phi = np.tile(phases[::EVERY], len(positions))
    a = a - a.mean()
    by_position, by_phase = _position_kernel(x, x), _phase_kernel(phi)
    magnitudes = _fit_magnitudes(by_position, by_phase, a)
    K = _covariance(magnitudes, by_position, by_phase)
    coefficients = magnitudes[0] ** 2 * np.linalg.solve(K, a)
    there, here = _position_kernel(reference, x), _position_kernel(positions[-1], x)
    return np.asarray((there - here) @ coefficients)


def _position_kernel(one: Vector, other: Vector) -> Matrix:
    return np.asarray(np.exp(-0.5 * ((one[:, None] - other) / POSITION_SCALE) ** 2))


def _phase_kernel(phi: Vector) -> Matrix:
    chord = np.sin((phi[:, None] - phi) / 2)
    return np.asarray(np.exp(-2 * (chord / PHASE_SCALE) ** 2))


def _covariance(magnitudes: Vector, by_position: Matrix, by_phase: Matrix) -> Matrix:
    g, p, noise = magnitudes
    jitter = 1e-9 * (g**2 + p**2) + noise**2
    return np.asarray(g**2 * by_position + p**2 * by_phase + jitter * np.eye(len(by_phase)))


def _fit_magnitudes(by_position: Matrix, by_phase: Matrix, a: Vector) -> Vector:
    """Find the magnitudes of g, p and noise at the largest posterior."""
    from scipy.optimize import minimize

    def loss(logarithms: Vector) -> float:
        K = _covariance(np.exp(logarithms), by_position, by_phase)
        try:
            L = np.linalg.cholesky(K)
        except np.linalg.LinAlgError:
            return 1e12
        whitened = np.linalg.solve(L, a)
        prior = ((logarithms - np.log(MEDIANS)) / DEVIATIONS) ** 2
        return float(0.5 * whitened @ whitened + np.log(np.diag(L)).sum() + 0.5 * prior.sum())

    found = minimize(loss, np.log(MEDIANS), method="Nelder-Mead", options={"maxiter": 300})
    return np.asarray(np.exp(found.x))
