from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsd_casadi.encoding.harmonics import (
    SAMPLES,
    analyze,
    highest_harmonic,
    sample_phases,
    synthesize,
    to_harmonics,
    to_weights,
)
from tsd_casadi.encoding.periodic_basis import PeriodicBasis

BASIS = PeriodicBasis()


def random_harmonics(seed: int, highest: int = 12, rows: int = 2) -> np.ndarray:
    rng = np.random.default_rng(seed)
    harmonics = rng.normal(size=(rows, highest + 1)) + 1j * rng.normal(size=(rows, highest + 1))
    harmonics[:, 0] = harmonics[:, 0].real
    return np.asarray(harmonics)


@pytest.mark.parametrize(("L", "highest"), [(1, 1), (3, 1), (25, 12), (26, 12), (1000, 127)])
def test_a_basis_holds_half_as_many_harmonics_as_functions(L: int, highest: int) -> None:
    assert highest_harmonic(PeriodicBasis.of_size(L)) == highest


def test_harmonics_are_those_of_the_fourier_series() -> None:
    phi = sample_phases()
    signal = 0.7 + 2 * np.cos(phi) - 3 * np.sin(4 * phi)
    expected = np.zeros(7, dtype=complex)
    expected[[0, 1, 4]] = 0.7, 1.0, 1.5j
    np.testing.assert_allclose(analyze(signal[None, :], 6)[0], expected, atol=1e-14)


@settings(max_examples=settings.default.max_examples // 3)
@given(seed=st.integers(0, 1000), highest=st.integers(1, SAMPLES // 2 - 1))
def test_signals_come_back_from_their_harmonics(seed: int, highest: int) -> None:
    harmonics = random_harmonics(seed, highest)
    np.testing.assert_allclose(analyze(synthesize(harmonics), highest), harmonics, atol=1e-12)


@settings(max_examples=settings.default.max_examples // 5)
@given(seed=st.integers(0, 1000))
def test_harmonics_of_weights_are_integrals_over_the_lap(seed: int) -> None:
    weights = np.random.default_rng(seed).normal(size=(2, BASIS.L))
    phi = np.linspace(0, 2 * np.pi, 5000, endpoint=False)
    signals = BASIS.evaluate(phi, weights)
    integrals = [np.mean(signals * np.exp(-1j * n * phi), axis=1) for n in range(13)]
    np.testing.assert_allclose(to_harmonics(BASIS, weights), np.transpose(integrals), atol=1e-12)


@settings(max_examples=settings.default.max_examples // 5)
@given(seed=st.integers(0, 1000), centers=st.integers(0, 24))
def test_moving_the_weights_turns_the_harmonics(seed: int, centers: int) -> None:
    weights = np.random.default_rng(seed).normal(size=(1, BASIS.L))
    turned = np.exp(-2j * np.pi * np.arange(13) * centers / BASIS.L)
    np.testing.assert_allclose(
        to_harmonics(BASIS, np.roll(weights, centers, axis=1)),
        to_harmonics(BASIS, weights) * turned,
        atol=1e-12,
    )


@settings(max_examples=settings.default.max_examples // 5)
@given(seed=st.integers(0, 1000))
def test_weights_keep_each_harmonic_apart_and_the_low_ones_whole(seed: int) -> None:
    harmonics = random_harmonics(seed)
    kept = to_harmonics(BASIS, to_weights(BASIS, harmonics)) / harmonics
    # shift-invariant: a share of each, the same whatever the others are
    np.testing.assert_allclose(kept.imag, 0, atol=1e-9)
    np.testing.assert_allclose(kept[0], kept[1], atol=1e-9)
    assert (np.diff(kept[0].real) < 1e-9).all()
    assert kept[0, 6].real > 0.995
    assert kept[0, 12].real > 0.5
