from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.encoding.periodic_basis import RIDGE, PeriodicBasis
from tsd_casadi.exceptions import InvalidValue

PHASES = st.floats(-100.0, 100.0)
SIZES = st.integers(1, 60)
WIDTHS = st.floats(1e-3, 9e5)


def one_by_one(basis: PeriodicBasis, phase: float, weights: np.ndarray) -> float:
    """Eqs. (basis_functions) and (psi) of the paper, written out."""
    above = below = 0.0
    for j in range(basis.L):
        center = 2 * math.pi * j / basis.L
        bump = math.exp(basis.width * (math.cos(phase - center) - 1))
        above += float(weights[j]) * bump
        below += bump
    return above / below


def lap_of_samples(count: int = 200) -> np.ndarray:
    return np.linspace(0, 2 * np.pi, count, endpoint=False)


def test_default_is_the_papers_basis() -> None:
    basis = PeriodicBasis()
    assert (basis.L, basis.width) == (25, 62.5)
    assert PeriodicBasis.of_size(25) == basis
    assert PeriodicBasis.of_size(10) == PeriodicBasis(10, 25.0)


@given(phase=PHASES, seed=st.integers(0, 1000))
def test_evaluate_is_the_closed_form(phase: float, seed: int) -> None:
    basis = PeriodicBasis()
    weights = np.random.default_rng(seed).normal(size=(2, basis.L))
    found = basis.evaluate([phase], weights)
    assert found.shape == (2, 1)
    for row in range(2):
        assert found[row, 0] == pytest.approx(one_by_one(basis, phase, weights[row]), abs=1e-10)


@given(phase=PHASES, size=SIZES, width=WIDTHS)
def test_values_sum_to_one(phase: float, size: int, width: float) -> None:
    values = PeriodicBasis(size, width).values([phase])
    assert values.shape == (1, size)
    assert values.min() >= 0
    assert values.sum() == pytest.approx(1.0, abs=1e-12)


@given(phase=st.floats(0.0, 2 * math.pi), turns=st.integers(-20, 20), width=st.floats(0.1, 100))
def test_values_are_periodic(phase: float, turns: int, width: float) -> None:
    basis = PeriodicBasis(25, width)
    # 20 turns cost about 1e-14 rad of phase, times the slope of the bumps
    np.testing.assert_allclose(
        basis.values([phase + 2 * np.pi * turns]), basis.values([phase]), atol=1e-11
    )


@given(phase=st.floats(0.0, 2 * math.pi), shift=st.integers(0, 24))
def test_all_bumps_have_one_shape(phase: float, shift: int) -> None:
    basis = PeriodicBasis()
    shifted = basis.values([phase + 2 * np.pi * shift / basis.L])
    np.testing.assert_allclose(shifted[0], np.roll(basis.values([phase])[0], shift), atol=1e-12)


def test_each_bump_peaks_at_its_centre() -> None:
    basis = PeriodicBasis()
    np.testing.assert_allclose(basis.centers, 2 * np.pi * np.arange(25) / 25)
    assert list(basis.values(basis.centers).argmax(axis=1)) == list(range(25))


def test_scalar_and_array_phases_agree() -> None:
    basis = PeriodicBasis()
    np.testing.assert_array_equal(basis.values(0.3), basis.values([0.3]))
    np.testing.assert_array_equal(basis.evaluate(0.3, np.arange(25.0)).shape, (1, 1))


@given(value=st.floats(-1e3, 1e3), phase=PHASES)
def test_equal_weights_are_a_constant_signal(value: float, phase: float) -> None:
    basis = PeriodicBasis()
    weights = np.full((1, basis.L), value)
    assert basis.evaluate([phase], weights)[0, 0] == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize("value", [-3.0, 0.0, 0.75])
def test_fit_of_a_constant_signal_is_equal_weights(value: float) -> None:
    phase = lap_of_samples()
    weights = PeriodicBasis().fit(phase, np.full((1, 200), value))
    np.testing.assert_allclose(weights, value, atol=1e-7)


@given(seed=st.integers(0, 1000))
def test_fit_recovers_weights(seed: int) -> None:
    basis = PeriodicBasis()
    weights = np.random.default_rng(seed).normal(size=(3, basis.L))
    phase = lap_of_samples() + np.pi
    np.testing.assert_allclose(basis.fit(phase, basis.evaluate(phase, weights)), weights, atol=1e-6)


def test_fit_is_the_ridge_least_squares_of_numpy() -> None:
    basis = PeriodicBasis()
    rng = np.random.default_rng(3)
    phase = rng.uniform(0, 6 * np.pi, size=400)
    signals = rng.normal(size=(2, 400))
    values = basis.values(phase)
    ridge = np.sqrt(RIDGE * np.sum(values**2) / basis.L) * np.eye(basis.L)
    padded = np.vstack([values, ridge])
    targets = np.vstack([signals.T, np.zeros((basis.L, 2))])
    expected = np.linalg.lstsq(padded, targets, rcond=None)[0].T
    np.testing.assert_allclose(basis.fit(phase, signals), expected, atol=1e-9)


def test_ridge_is_too_small_to_be_seen_on_a_whole_lap() -> None:
    basis = PeriodicBasis()
    phase = lap_of_samples()
    signal = np.cos(2 * phase)[None, :] + 0.3
    plain = np.linalg.lstsq(basis.values(phase), signal[0], rcond=None)[0]
    np.testing.assert_allclose(basis.fit(phase, signal)[0], plain, atol=1e-6)


@pytest.mark.parametrize("harmonic", [1, 2, 3])
def test_slow_harmonics_are_encoded_closely(harmonic: int) -> None:
    basis = PeriodicBasis()
    phase = lap_of_samples()
    signal = np.sin(harmonic * phase + 0.4)[None, :]
    rebuilt = basis.evaluate(phase, basis.fit(phase, signal))
    assert np.abs(rebuilt - signal).max() < 0.01 * harmonic


def test_fit_stays_finite_where_there_are_no_samples() -> None:
    basis = PeriodicBasis()
    phase = np.linspace(0, np.pi / 2, 100)
    weights = basis.fit(phase, np.ones((1, 100)))
    assert np.isfinite(weights).all()
    assert np.abs(weights).max() < 10


@given(scale=st.floats(-10, 10))
def test_fit_is_linear_in_the_signal(scale: float) -> None:
    basis = PeriodicBasis()
    phase = lap_of_samples(200)
    one, other = np.sin(phase)[None, :], np.cos(3 * phase)[None, :]
    together = basis.fit(phase, one + scale * other)
    apart = basis.fit(phase, one) + scale * basis.fit(phase, other)
    np.testing.assert_allclose(together, apart, atol=1e-8)


@given(phase=PHASES, width=st.floats(1e4, 9.99e5), size=st.integers(1, 5))
def test_narrow_bumps_do_not_underflow(phase: float, width: float, size: int) -> None:
    values = PeriodicBasis(size, width).values([phase])
    assert np.isfinite(values).all()
    assert values.sum() == pytest.approx(1.0)


@pytest.mark.parametrize("size", [0, -1, -25])
def test_no_functions_are_refused(size: int) -> None:
    with pytest.raises(InvalidValue, match="L is") as caught:
        PeriodicBasis(size, 1.0)
    assert caught.value.field == "L"


@pytest.mark.parametrize("width", [0.0, -1.0, math.nan, math.inf, 1e6])
def test_impossible_widths_are_refused(width: float) -> None:
    with pytest.raises(InvalidValue, match="width is") as caught:
        PeriodicBasis(25, width)
    assert caught.value.field == "width"


def test_bases_compare_by_value() -> None:
    assert PeriodicBasis(10, 3.0) == PeriodicBasis(10, 3.0)
    assert PeriodicBasis(10, 3.0) != PeriodicBasis(10, 3.1)
    assert PeriodicBasis(10, 3.0) != PeriodicBasis(11, 3.0)
