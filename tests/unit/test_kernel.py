from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import approx_fprime
from sklearn.gaussian_process.kernels import ConstantKernel, DotProduct, Exponentiation, Matern

from tsd_casadi.generalization.kernel import NEXT_DEGREE, PLANE, Kernel

FEW = settings(max_examples=settings.default.max_examples // 5)
HYPERPARAMETERS = st.lists(st.floats(-3.0, 1.0), min_size=5, max_size=5).map(np.array)


def places_of(seed: int, count: int = 6) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1, 1, (count, 2))


@FEW
@given(theta=HYPERPARAMETERS, seed=st.integers(0, 1000))
def test_it_is_the_sum_of_a_polynomial_and_a_matern_process(theta: np.ndarray, seed: int) -> None:
    kernel = Kernel.of_logarithms(theta)
    product = DotProduct(0.0, "fixed")
    expected = (
        ConstantKernel(PLANE)
        + ConstantKernel(PLANE) * product
        + ConstantKernel(kernel.higher / 4) * Exponentiation(product, 2)
        + ConstantKernel(NEXT_DEGREE * kernel.higher / 4) * Exponentiation(product, 3)
        + ConstantKernel(kernel.rough) * Matern(kernel.lengths, nu=2.5)
    )
    one, other = places_of(seed), places_of(seed + 1, 4)
    np.testing.assert_allclose(kernel.covariance(one, other), expected(one, other), rtol=1e-9)
    np.testing.assert_allclose(kernel.variance(one), expected.diag(one), rtol=1e-9)


@FEW
@given(theta=HYPERPARAMETERS, seed=st.integers(0, 1000))
def test_the_pull_of_each_hyperparameter_is_the_derivative(theta: np.ndarray, seed: int) -> None:
    places, weights = places_of(seed), np.random.default_rng(seed).normal(size=(6, 6))
    weights = weights + weights.T

    def total(at: np.ndarray) -> float:
        kernel = Kernel.of_logarithms(at)
        covariance = kernel.covariance(places, places) + kernel.noise * np.eye(6)
        return float(np.sum(weights * covariance))

    expected = approx_fprime(theta, total, 1e-6)
    found = Kernel.of_logarithms(theta).pull(places, weights)
    np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-4)


@FEW
@given(theta=HYPERPARAMETERS, seed=st.integers(0, 1000))
def test_no_variance_is_negative(theta: np.ndarray, seed: int) -> None:
    places = places_of(seed)
    covariance = Kernel.of_logarithms(theta).covariance(places, places)
    assert np.linalg.eigvalsh(covariance).min() > -1e-9 * np.trace(covariance)


def test_it_is_told_with_its_length_scales() -> None:
    text = str(Kernel.of_logarithms(np.log([0.1, 0.3, 1e-4, 0.5, 4.0])))
    assert "0.3 Matern 5/2 (length scales 0.5, 4)" in text
    assert "noise 0.0001" in text


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_longer_length_is_less_rough(factor: float) -> None:
    theta = np.log([0.1, 0.3, 1e-4, 1.0, 1.0])
    longer = theta + np.array([0, 0, 0, *[np.log(factor)] * 2])
    places = np.array([[0.0, 0.0], [0.5, 0.5]])
    one, other = (Kernel.of_logarithms(t).covariance(places, places)[0, 1] for t in (theta, longer))
    assert (other > one) == (factor > 1)
