from __future__ import annotations

import re
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from tsd_casadi.exceptions import EntryNotFound, OutsideTrainedRange
from tsd_casadi.generalization import WeightRegression

AMPLITUDES = (0.02, 0.04, 0.06, 0.08)
SHAPE = (2, 5)


def learned(amplitude: float, seed: int = 0) -> np.ndarray:
    """Weights that depend smoothly on the amplitude, each in its own way."""
    rng = np.random.default_rng(seed)
    offset, slope, bend = rng.normal(size=(3, *SHAPE))
    return np.asarray(offset + 20 * slope * amplitude + 100 * bend * amplitude**2)


@cache
def regression_of(amplitudes: tuple[float, ...] = AMPLITUDES, seed: int = 0) -> WeightRegression:
    weights = [learned(amplitude, seed) for amplitude in amplitudes]
    return WeightRegression("amplitude", "m", amplitudes, weights)


def posterior(
    kernel: tuple[float, float, float], amplitudes: np.ndarray, targets: np.ndarray, value: float
) -> tuple[np.ndarray, np.ndarray]:
    """Gaussian process posterior, written out with numpy.

    Args:
        kernel: Signal variance, length scale (database spans 1), noise variance.
        amplitudes: Inputs (n,).
        targets: (n, weights).
        value: Where to predict.
    """
    variance, length, noise = kernel
    low, span = amplitudes.min(), np.ptp(amplitudes)
    x, x_new = (amplitudes - low) / span, (value - low) / span

    def covariance(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.asarray(variance * np.exp(-((a[:, None] - b[None, :]) ** 2) / (2 * length**2)))

    mean, deviation = targets.mean(axis=0), targets.std(axis=0)
    # sklearn adds 1e-10 to the diagonal of what it inverts
    K = covariance(x, x) + (noise + 1e-10) * np.eye(len(x))
    k_new = covariance(np.array([x_new]), x)[0]
    predicted = mean + deviation * (k_new @ np.linalg.solve(K, (targets - mean) / deviation))
    left = variance + noise - k_new @ np.linalg.solve(K, k_new)
    return predicted, deviation * np.sqrt(left)


def fitted_kernel(regression: WeightRegression) -> tuple[float, float, float]:
    """Exact hyperparameters; the string for people is rounded."""
    kernel = regression._process.kernel_
    return (
        kernel.k1.k1.constant_value,
        kernel.k1.k2.length_scale,
        kernel.k2.noise_level,
    )


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("value", [0.02, 0.025, 0.05, 0.0612, 0.08])
def test_prediction_is_the_closed_form_posterior(seed: int, value: float) -> None:
    regression = regression_of(seed=seed)
    targets = np.stack([learned(amplitude, seed).ravel() for amplitude in AMPLITUDES])
    expected = posterior(fitted_kernel(regression), np.array(AMPLITUDES), targets, value)
    mean, std = regression.predict(value)
    assert mean.shape == std.shape == SHAPE
    np.testing.assert_allclose(mean.ravel(), expected[0], rtol=0, atol=1e-8)
    np.testing.assert_allclose(std.ravel(), expected[1], rtol=0, atol=1e-8)


def test_extrapolation_is_the_same_posterior() -> None:
    regression = regression_of()
    targets = np.stack([learned(amplitude).ravel() for amplitude in AMPLITUDES])
    expected = posterior(fitted_kernel(regression), np.array(AMPLITUDES), targets, 0.1)
    mean, std = regression.predict(0.1, extrapolate=True)
    np.testing.assert_allclose(mean.ravel(), expected[0], atol=1e-8)
    np.testing.assert_allclose(std.ravel(), expected[1], atol=1e-8)


def test_hyperparameters_maximise_the_likelihood() -> None:
    regression = regression_of()
    best = regression._process.log_marginal_likelihood_value_
    theta = regression._process.kernel_.theta
    bounds = regression._process.kernel_.bounds
    for index in range(len(theta)):
        for step in (-0.3, 0.3):
            moved = theta.copy()
            moved[index] = np.clip(moved[index] + step, *bounds[index])
            assert regression._process.log_marginal_likelihood(moved) <= best + 1e-6


def test_smooth_dependence_is_predicted_between_the_entries() -> None:
    mean, std = regression_of().predict(0.05)
    spread = np.stack([learned(a) for a in AMPLITUDES]).std(axis=0)
    assert np.all(np.abs(mean - learned(0.05)) < 0.1 * spread)
    assert np.all(std > 0)


def test_learned_values_are_nearly_reproduced() -> None:
    regression = regression_of()
    for amplitude in AMPLITUDES:
        mean, _ = regression.predict(amplitude)
        spread = np.stack([learned(a) for a in AMPLITUDES]).std(axis=0)
        assert np.all(np.abs(mean - learned(amplitude)) < 0.05 * spread)


def test_uncertainty_grows_away_from_the_entries() -> None:
    regression = regression_of()
    values = (0.08, 0.1, 0.15, 0.3)
    deviations = [regression.predict(value, extrapolate=True)[1].mean() for value in values]
    assert all(near < far for near, far in pairwise(deviations))


@pytest.mark.parametrize("order", [(3, 2, 1, 0), (1, 3, 0, 2)])
def test_order_of_entries_does_not_matter(order: tuple[int, ...]) -> None:
    shuffled = regression_of(tuple(AMPLITUDES[i] for i in order))
    np.testing.assert_array_equal(shuffled.inputs, AMPLITUDES)
    for one, other in zip(shuffled.predict(0.05), regression_of().predict(0.05), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


def test_the_same_content_gives_the_same_answer() -> None:
    regression_of.cache_clear()
    again = regression_of()
    regression_of.cache_clear()
    for one, other in zip(regression_of().predict(0.05), again.predict(0.05), strict=True):
        np.testing.assert_array_equal(one, other)


def test_input_arrays_are_not_changed() -> None:
    weights = [learned(amplitude) for amplitude in AMPLITUDES]
    before = [array.copy() for array in weights]
    WeightRegression("amplitude", "m", AMPLITUDES, weights).predict(0.05)
    for one, other in zip(weights, before, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("value", [0.0199, 0.0801, 0.0, -1.0, np.nan, np.inf])
def test_outside_the_learned_range_is_refused_with_the_range(value: float) -> None:
    with pytest.raises(OutsideTrainedRange, match=re.escape("0.02 to 0.08 m")) as caught:
        regression_of().predict(value)
    assert (caught.value.low, caught.value.high) == (0.02, 0.08)
    assert caught.value.parameter == "amplitude"
    assert "extrapolate=true" in str(caught.value)


@pytest.mark.parametrize("value", [0.01, 0.0801, 0.12])
def test_extrapolate_answers_outside(value: float) -> None:
    mean, std = regression_of().predict(value, extrapolate=True)
    assert np.isfinite(mean).all()
    assert np.isfinite(std).all()


@pytest.mark.parametrize("amplitudes", [(), (0.05,)])
def test_too_few_entries_are_refused(amplitudes: tuple[float, ...]) -> None:
    with pytest.raises(EntryNotFound, match="at least 2"):
        regression_of(amplitudes)


def test_two_entries_are_enough() -> None:
    regression = regression_of((0.02, 0.06))
    mean, std = regression.predict(0.04)
    targets = np.stack([learned(a).ravel() for a in (0.02, 0.06)])
    expected = posterior(fitted_kernel(regression), np.array([0.02, 0.06]), targets, 0.04)
    np.testing.assert_allclose(mean.ravel(), expected[0], atol=1e-8)
    np.testing.assert_allclose(std.ravel(), expected[1], atol=1e-8)


def test_weights_that_never_differ_are_predicted_as_they_are() -> None:
    weights = [np.full(SHAPE, 0.7)] * 3
    mean, std = WeightRegression("amplitude", "m", (0.02, 0.04, 0.06), weights).predict(0.05)
    np.testing.assert_allclose(mean, 0.7, atol=1e-12)
    assert np.isfinite(std).all()


def test_kernel_can_be_shown() -> None:
    text = regression_of().kernel
    assert "RBF" in text
    assert "WhiteKernel" in text
