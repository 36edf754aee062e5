from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import norm
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.generalization.predictive_deviation import (
    deviation_scale,
    lap,
    leave_one_out,
    student_factor,
)

BASIS = PeriodicBasis()


@settings(max_examples=settings.default.max_examples // 4)
@given(seed=st.integers(0, 1000), n=st.integers(2, 12), noise=st.floats(1e-4, 1.0))
def test_leave_one_out_is_what_leaving_out_gives(seed: int, n: int, noise: float) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(size=(n, 2)), rng.normal(size=(n, 3))
    kernel = ConstantKernel(2.0) * RBF([0.5, 2.0]) + WhiteKernel(noise)
    residuals, deviations = leave_one_out(kernel(x), y)
    for i in range(n):
        others = np.arange(n) != i
        process = GaussianProcessRegressor(kernel, alpha=0.0, optimizer=None)
        mean, std = process.fit(x[others], y[others]).predict(x[[i]], return_std=True)
        np.testing.assert_allclose(residuals[i], y[i] - mean[0], rtol=1e-6, atol=1e-8)
        np.testing.assert_allclose(deviations[i], std[0], rtol=1e-6)


def test_leave_one_out_of_unrelated_targets_is_the_targets() -> None:
    y = np.array([[1.0, -2.0], [3.0, 4.0]])
    residuals, deviations = leave_one_out(4 * np.eye(2), y)
    np.testing.assert_allclose(residuals, y)
    np.testing.assert_allclose(deviations, [2.0, 2.0])


def test_scale_is_the_rms_of_residuals_that_are_alike_everywhere() -> None:
    residuals = np.stack([np.full((1, BASIS.L), value) for value in (0.3, -0.3, 0.3, 0.3)])
    scale = deviation_scale(BASIS, residuals)
    np.testing.assert_allclose(scale, 0.3 * student_factor(4), rtol=1e-12)


def test_scale_is_larger_where_the_residuals_are() -> None:
    rng = np.random.default_rng(0)
    magnitude = np.where(np.abs(BASIS.centers - np.pi) < 0.5, 1.0, 0.1)
    residuals = rng.normal(size=(12, 1, BASIS.L)) * magnitude
    scale = deviation_scale(BASIS, residuals)[0]
    assert scale[magnitude == 1.0].min() > 1.2 * scale[magnitude < 1.0].max()
    # few entries: drawn towards the lap's mean, but not above the largest
    assert scale.min() > 0.1
    assert scale.max() < 1.5 * student_factor(12)


def test_axes_do_not_mix() -> None:
    rng = np.random.default_rng(1)
    one, other = rng.normal(size=(2, 6, 1, BASIS.L))
    both = deviation_scale(BASIS, np.concatenate([one, other], axis=1))
    np.testing.assert_allclose(both[:1], deviation_scale(BASIS, one))
    np.testing.assert_allclose(both[1:], deviation_scale(BASIS, other))


@settings(max_examples=settings.default.max_examples // 5)
@given(factor=st.floats(1e-6, 1e6), seed=st.integers(0, 100))
def test_scale_has_the_unit_of_the_residuals(factor: float, seed: int) -> None:
    residuals = np.random.default_rng(seed).normal(size=(5, 2, BASIS.L))
    expected = factor * deviation_scale(BASIS, residuals)
    np.testing.assert_allclose(deviation_scale(BASIS, factor * residuals), expected, rtol=1e-9)


@pytest.mark.parametrize("n", [3, 5, 12])
def test_student_factor_covers_a_normal_sample_of_unknown_deviation(n: int) -> None:
    rng = np.random.default_rng(2)
    sample, next_one = rng.normal(size=(200_000, n - 1)), rng.normal(size=200_000)
    deviation = student_factor(n) * np.sqrt(np.mean(sample**2, axis=1))
    covered = np.mean(np.abs(next_one) < 2 * deviation)
    assert covered == pytest.approx(norm.cdf(2) - norm.cdf(-2), abs=2e-3)


def test_many_entries_need_no_factor() -> None:
    assert student_factor(100_000) == pytest.approx(1.0, abs=1e-3)


def test_a_lap_is_dense_and_does_not_repeat_its_start() -> None:
    phase = lap(BASIS)
    np.testing.assert_allclose(np.diff(phase), 2 * np.pi / len(phase))
    assert phase[-1] < 2 * np.pi
    assert len(phase) >= 4 * BASIS.L
