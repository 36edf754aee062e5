from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.generalization.predictive_deviation import (
    band_factor,
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
    for size in (0.3, 1.0, 3.0):
        residuals = np.stack([np.full((1, BASIS.L), size * sign) for sign in (1, -1) * 100])
        scale = deviation_scale(BASIS, residuals, 1)
        np.testing.assert_allclose(scale, size, rtol=0.05)


def test_scale_of_few_entries_is_nearer_to_what_the_process_expects() -> None:
    scales = [
        deviation_scale(BASIS, np.full((n, 1, BASIS.L), 0.1), 1).mean() / student_factor(n, 1)
        for n in (3, 10, 100)
    ]
    assert 1 > scales[0] > scales[1] > scales[2] > 0.1


def test_scale_is_larger_where_the_residuals_are() -> None:
    rng = np.random.default_rng(0)
    magnitude = np.where(np.abs(BASIS.centers - np.pi) < 0.5, 1.0, 0.1)
    residuals = rng.normal(size=(12, 1, BASIS.L)) * magnitude
    scale = deviation_scale(BASIS, residuals, 2)[0]
    assert scale[magnitude == 1.0].min() > 1.2 * scale[magnitude < 1.0].max()
    # few entries: drawn towards the lap's mean, but not above the largest
    assert scale.min() > 0.1
    assert scale.max() < 1.5 * student_factor(12, 2)


def test_axes_do_not_mix() -> None:
    rng = np.random.default_rng(1)
    one, other = rng.normal(size=(2, 6, 1, BASIS.L))
    together = np.concatenate([one, 3 * other], axis=1)
    both = deviation_scale(BASIS, together, 2)
    np.testing.assert_allclose(both[:1], deviation_scale(BASIS, one, 2))
    np.testing.assert_allclose(both[1:], deviation_scale(BASIS, 3 * other, 2))
    factors = band_factor(BASIS, together, both, 2)
    assert factors[1] == pytest.approx(band_factor(BASIS, 3 * other, both[1:], 2)[0])


def test_the_factor_is_the_quantile_of_students_distribution() -> None:
    # without an entry beyond those of a plane three numbers are left to tell the scale, with each
    # further one two more: tables of Student's t at 97.725 %
    assert 2 * student_factor(4, 3) == pytest.approx(3.307, rel=1e-3)
    assert 2 * student_factor(4, 2) == pytest.approx(2.649, rel=1e-3)
    assert 2 * student_factor(6, 3) == pytest.approx(2.429, rel=1e-3)


@pytest.mark.parametrize("entries", [1, 4, 8])
def test_fewer_entries_than_a_plane_takes_tell_no_less_than_nothing(entries: int) -> None:
    assert student_factor(entries, 7) == student_factor(8, 7)


def test_many_entries_need_no_factor() -> None:
    assert student_factor(100_000, 3) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("n", [6, 40])
def test_the_band_holds_whole_smooth_curves(n: int) -> None:
    """Of curves with the residuals' own distribution."""
    rng = np.random.default_rng(3)
    inside = []
    for _ in range(40):
        curves = rng.normal(size=(n + 20, 1, BASIS.L))
        scale = deviation_scale(BASIS, curves[:n], 1)
        half = band_factor(BASIS, curves[:n], scale, 1)[:, None] * scale
        values = BASIS.values(lap(BASIS)).T
        inside.append(np.all(np.abs(curves[n:] @ values) <= half @ values, axis=2))
    assert np.mean(inside) >= 0.95


def test_the_band_goes_as_far_as_whole_laps_went() -> None:
    rng = np.random.default_rng(4)
    residuals = rng.normal(size=(12, 1, BASIS.L))
    scale = deviation_scale(BASIS, residuals, 1)
    values = BASIS.values(lap(BASIS)).T
    (calm,) = band_factor(BASIS, residuals, scale, 1)
    residuals[7] *= 10
    (factor,) = band_factor(BASIS, residuals, scale, 1)
    assert factor == pytest.approx(np.max(np.abs(residuals @ values) / (scale @ values)))
    assert factor > 2 * calm


def test_a_lap_is_dense_and_does_not_repeat_its_start() -> None:
    phase = lap(BASIS)
    np.testing.assert_allclose(np.diff(phase), 2 * np.pi / len(phase))
    assert phase[-1] < 2 * np.pi
    assert len(phase) >= 4 * BASIS.L
