from __future__ import annotations

import numpy as np
import pinocchio
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from tsd_casadi.identification.physical_consistency import (
    PARAMETERS,
    body,
    fit_consistent,
    pseudo_inertia,
    scalar,
)


def random_body(seed: int) -> np.ndarray:
    """Parameters of a cloud of points."""
    rng = np.random.default_rng(seed)
    points, masses = rng.normal(size=(8, 3)), rng.uniform(0.1, 1.0, 8)
    inertia = sum(
        m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, points, strict=True)
    )
    first = masses @ points
    entries = [inertia[i, j] for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))]
    return np.array([masses.sum(), *first, *entries])


def test_pseudo_inertia_is_pinocchios() -> None:
    for seed in range(5):
        parameters = random_body(seed)
        theirs = pinocchio.PseudoInertia.FromDynamicParameters(parameters).toMatrix()
        np.testing.assert_allclose(pseudo_inertia(parameters), theirs, atol=1e-12)


def test_without_data_the_nominal_body_stays() -> None:
    nominal = np.concatenate((random_body(0), [2.0]))
    x = fit_consistent(
        np.zeros((1, 11)), np.zeros(1), nominal, [body(0, 1.0), scalar(PARAMETERS, 3.0)]
    )
    np.testing.assert_allclose(x, nominal, rtol=1e-8)


def test_a_scalar_has_a_closed_form() -> None:
    """Of (a x - b)^2 / 2 + g (x / p - log(x / p) - 1)."""
    a, b, g, p = 2.0, -3.0, 0.5, 4.0
    x = fit_consistent(np.array([[a]]), np.array([b]), np.array([p]), [scalar(0, g)])
    roots = np.roots([a**2, -a * b + g / p, -g])
    np.testing.assert_allclose(x, roots[roots > 0], rtol=1e-6)


def test_it_is_the_minimum() -> None:
    rng = np.random.default_rng(1)
    nominal = random_body(2)
    A, b = rng.normal(size=(6, PARAMETERS)), rng.normal(size=6)
    gamma = 0.7

    def cost(x: np.ndarray) -> float:
        ratio = np.linalg.solve(pseudo_inertia(nominal), pseudo_inertia(x))
        _, log_det = np.linalg.slogdet(ratio)
        if np.linalg.eigvalsh(pseudo_inertia(x)).min() <= 0:
            return np.inf
        return float(np.sum((A @ x - b) ** 2) / 2 + gamma * (np.trace(ratio) - log_det - 4))

    x = fit_consistent(A, b, nominal, [body(0, gamma)])
    found = minimize(
        cost, nominal, method="Nelder-Mead", options={"maxiter": 20000, "maxfev": 20000}
    )
    assert cost(x) <= found.fun + 1e-9
    for direction in rng.normal(size=(20, PARAMETERS)):
        assert cost(x + 1e-4 * direction) > cost(x)


@settings(max_examples=settings.default.max_examples // 5)
@given(seed=st.integers(0, 2**31), size=st.floats(1e-2, 30.0))
def test_bodies_stay_possible_whatever_the_data_say(seed: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    nominal = np.concatenate((random_body(seed), random_body(seed + 1), [1.0]))
    A, b = size * rng.normal(size=(30, 21)), size * rng.normal(size=30)
    x = fit_consistent(A, b, nominal, [body(0, 1e-2), body(PARAMETERS, 1e-2), scalar(20, 1e-2)])
    for start in (0, PARAMETERS):
        assert np.linalg.eigvalsh(pseudo_inertia(x[start : start + PARAMETERS])).min() > 0
    assert x[20] > 0
