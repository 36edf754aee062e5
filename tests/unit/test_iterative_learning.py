from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsd_casadi.encoding.laps import Lap, fit_laps
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.iterative_learning import update_weights

BASIS = PeriodicBasis()
PHASE = np.pi + np.linspace(0, 2 * np.pi, 200, endpoint=False)


def lap_of(feedback: np.ndarray) -> Lap:
    return Lap(PHASE, np.atleast_2d(feedback))


def update(weights: np.ndarray, laps: list[Lap], gain: float = 1.0) -> np.ndarray:
    return update_weights(weights, fit_laps(laps, BASIS).feedback, gain)


def random_weights(seed: int, rows: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(rows, BASIS.L))


def harmonic(signal: np.ndarray) -> complex:
    """The first harmonic of a signal at PHASE."""
    return complex(2 * np.mean(signal * np.exp(-1j * PHASE)))


class WrongMass:
    """A cart whose mass is 1 / ratio of what its controller takes it for.

    The controller asks for a = xdd_ref + P e + D de + feedforward and the cart
    gets ratio * a, so along x_ref = A sin(Omega t), with S and T the loop's
    sensitivities at Omega:

        feedback = T ((1 - ratio) / ratio * xdd_ref - feedforward)
        T = ratio (P + D s) / (s^2 + ratio (P + D s)),  S = 1 - T
    """

    ratio, P, D, frequency, amplitude = 1.1, 50.0, 14.0, 0.5, 0.05

    @property
    def complementary_sensitivity(self) -> complex:
        s = 2j * np.pi * self.frequency
        loop = self.ratio * (self.P + self.D * s)
        return complex(loop / (s**2 + loop))

    @property
    def needed(self) -> np.ndarray:
        """The feedforward at which the error is zero, at PHASE."""
        omega = 2 * np.pi * self.frequency
        acceleration = -self.amplitude * omega**2 * np.sin(PHASE)
        return np.asarray((1 - self.ratio) / self.ratio * acceleration)

    def feedback(self, missing: np.ndarray) -> np.ndarray:
        """Steady feedback where a sine of one lap is missing from the feedforward."""
        phasor = self.complementary_sensitivity * harmonic(missing)
        return np.asarray(np.real(phasor * np.exp(1j * PHASE)))


@pytest.mark.parametrize("gain", [1.0, 0.5, 0.25])
def test_error_of_a_linear_loop_contracts_as_in_closed_form(gain: float) -> None:
    plant = WrongMass()
    contraction = abs(1 - gain * plant.complementary_sensitivity)
    assert 0.1 < contraction < 0.9  # neither trivial nor divergent
    weights = np.zeros((1, BASIS.L))
    first = harmonic(plant.needed)
    for repetition in range(1, 7):
        missing = plant.needed - BASIS.evaluate(PHASE, weights)[0]
        weights = update(weights, [lap_of(plant.feedback(missing))], gain)
        left = plant.needed - BASIS.evaluate(PHASE, weights)[0]
        assert abs(harmonic(left) / first) == pytest.approx(contraction**repetition, abs=1e-4)


def test_constant_disturbance_is_learned_at_once() -> None:
    # at zero frequency T is one: the feedback is all that is missing
    weights = update(np.zeros((1, BASIS.L)), [lap_of(np.full(200, 0.75))])
    np.testing.assert_allclose(BASIS.evaluate(PHASE, weights), 0.75, atol=1e-8)


def test_no_feedback_leaves_the_weights_alone() -> None:
    applied = random_weights(1)
    np.testing.assert_allclose(update(applied, [lap_of(np.zeros(200))]), applied, atol=1e-15)


@settings(max_examples=settings.default.max_examples // 5)
@given(seed=st.integers(0, 100), gain=st.floats(0.0, 1.0))
def test_update_adds_gain_times_what_was_fitted(seed: int, gain: float) -> None:
    applied, added = random_weights(seed, 2), random_weights(seed + 1000, 2)
    laps = [lap_of(BASIS.evaluate(PHASE, added))]
    np.testing.assert_allclose(update(applied, laps, gain), applied + gain * added, atol=1e-6)


@settings(max_examples=settings.default.max_examples // 5)
@given(seed=st.integers(0, 100), scale=st.floats(-5.0, 5.0))
def test_update_is_linear_in_weights_and_feedback(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    feedback = rng.normal(size=(2, 200))
    applied = rng.normal(size=(2, BASIS.L))
    separate = [update(applied[[i]], [lap_of(feedback[i])], 0.5) for i in range(2)]
    together = update(
        applied[[0]] + scale * applied[[1]],
        [lap_of(feedback[0] + scale * feedback[1])],
        0.5,
    )
    np.testing.assert_allclose(together, separate[0] + scale * separate[1], atol=1e-9)


def test_axes_are_learned_independently() -> None:
    feedback = np.vstack([np.sin(PHASE), np.cos(PHASE)])
    both = update(np.zeros((2, BASIS.L)), [lap_of(feedback)])
    for row in range(2):
        alone = update(np.zeros((1, BASIS.L)), [lap_of(feedback[row])])
        np.testing.assert_allclose(both[[row]], alone, atol=1e-12)


def test_several_laps_are_averaged() -> None:
    laps = [lap_of(np.sin(PHASE) + offset) for offset in (-0.2, 0.0, 0.5)]
    averaged = update(np.zeros((1, BASIS.L)), laps)
    expected = update(np.zeros((1, BASIS.L)), [lap_of(np.sin(PHASE) + 0.1)])
    np.testing.assert_allclose(averaged, expected, atol=1e-9)


def test_applied_weights_are_not_changed_in_place() -> None:
    applied = random_weights(5)
    before = applied.copy()
    update(applied, [lap_of(np.ones(200))])
    np.testing.assert_array_equal(applied, before)
