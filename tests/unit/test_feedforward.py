from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.band import Band
from tsd_casadi.learning.feedforward import Feedforward

BASIS = PeriodicBasis()
AXES = ("com.x", "com.z")
PHASES = np.linspace(0, 2 * np.pi, 50)


def a_feedforward(seed: int = 0) -> Feedforward:
    rng = np.random.default_rng(seed)
    return Feedforward(
        AXES,
        BASIS,
        rng.normal(size=(2, BASIS.L)),
        rng.uniform(0, 0.1, size=(2, BASIS.L)),
        "generalised",
        {"amplitude": 0.05, "frequency": 0.25},
        {"iteration": 3},
    )


def closed_form_values(phase: float) -> list[float]:
    bumps = [
        math.exp(BASIS.width * (math.cos(phase - 2 * math.pi * j / BASIS.L) - 1))
        for j in range(BASIS.L)
    ]
    return [bump / sum(bumps) for bump in bumps]


@settings(max_examples=settings.default.max_examples // 2)
@given(phase=st.floats(-20, 20), seed=st.integers(0, 100))
def test_mean_is_the_weighted_sum_of_normalised_bumps(phase: float, seed: int) -> None:
    feedforward = a_feedforward(seed)
    psi = closed_form_values(phase)
    for row in range(2):
        expected = sum(w * p for w, p in zip(feedforward.weights[row], psi, strict=True))
        assert feedforward.mean([phase])[row, 0] == pytest.approx(expected, abs=1e-12)


@settings(max_examples=settings.default.max_examples // 2)
@given(phase=st.floats(-20, 20), seed=st.integers(0, 100))
def test_std_is_the_same_sum_of_standard_deviations(phase: float, seed: int) -> None:
    feedforward = a_feedforward(seed)
    psi = closed_form_values(phase)
    for row in range(2):
        expected = sum(
            d * p for d, p in zip(feedforward.standard_deviations[row], psi, strict=True)
        )
        assert feedforward.std([phase])[row, 0] == pytest.approx(expected, abs=1e-12)


def test_std_of_weights_that_err_together_is_that_of_samples() -> None:
    feedforward = a_feedforward()
    errors = np.random.default_rng(1).normal(size=(20_000, 2, 1))
    samples = feedforward.weights + feedforward.standard_deviations * errors
    signals = samples @ BASIS.values(PHASES).T
    np.testing.assert_allclose(signals.std(axis=0), feedforward.std(PHASES), rtol=0.03)


def test_mean_and_std_have_one_row_per_axis() -> None:
    feedforward = a_feedforward()
    assert feedforward.mean(PHASES).shape == feedforward.std(PHASES).shape == (2, 50)


def test_zero_is_none_and_nothing() -> None:
    zero = Feedforward.zero(AXES, BASIS)
    assert (zero.kind, zero.iteration, zero.axes) == ("none", 0, AXES)
    assert not zero.mean(PHASES).any()
    assert not zero.std(PHASES).any()


def test_iteration_is_that_of_the_provenance() -> None:
    assert a_feedforward().iteration == 3


def test_constant_keeps_only_the_mean_over_a_lap() -> None:
    feedforward = a_feedforward()
    constant = feedforward.constant()
    lap = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
    mean = feedforward.mean(lap).mean(axis=1, keepdims=True)
    np.testing.assert_allclose(constant.mean(PHASES), np.repeat(mean, 50, axis=1), atol=1e-9)
    assert constant.kind == "constant"
    assert not constant.std(PHASES).any()
    assert constant.axes == feedforward.axes
    assert constant.parameters == feedforward.parameters
    assert constant.provenance == feedforward.provenance


def test_constant_of_a_pure_oscillation_is_zero() -> None:
    phase = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
    weights = BASIS.fit(phase, np.vstack([np.sin(phase), np.cos(2 * phase)]))
    oscillation = Feedforward(AXES, BASIS, weights, np.zeros_like(weights), "learned")
    assert np.abs(oscillation.constant().mean(PHASES)).max() < 1e-9


def test_constant_twice_is_constant_once() -> None:
    once = a_feedforward().constant()
    np.testing.assert_allclose(once.constant().weights, once.weights, atol=1e-14)


def test_bands_go_with_the_axes_and_not_with_a_constant() -> None:
    feedforward = a_feedforward()
    band = Band("simultaneous", 0.95, 3 * feedforward.standard_deviations)
    banded = replace(feedforward, bands=(band,))
    (other,) = banded.over(("com.z", "com.y")).bands
    np.testing.assert_array_equal(other.half_width[0], band.half_width[1])
    np.testing.assert_array_equal(other.half_width[1], 0.0)
    assert (other.kind, other.coverage) == ("simultaneous", 0.95)
    assert banded.constant().bands == ()
