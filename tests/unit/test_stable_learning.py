"""Learning rules on a linear loop that is simulated in time, knowing nothing of harmonics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from tsd_casadi.encoding.harmonics import to_harmonics, to_weights
from tsd_casadi.encoding.laps import Lap, fit_laps
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.learning.iteration import FittedRepetition
from tsd_casadi.learning.iterative_learning import update_stably, update_weights
from tsd_casadi.learning.loop_response import estimate_response
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.rules.by_name import find_rule

BASIS = PeriodicBasis()
NOTHING = np.zeros((1, BASIS.L))
EXCITED = (1, 2, 5, 9)


def rich(phase: float, x: float) -> float:
    """A disturbance of the harmonics EXCITED that is no function of the position."""
    return float(
        0.5
        + 0.3 * np.cos(phase)
        + 0.3 * np.sin(2 * phase)
        + 0.2 * np.cos(5 * phase)
        + 0.1 * np.sin(9 * phase)
    )


@dataclass
class LinearPlant:
    """x'' = gain * (x_ref'' + u + P e + D e')(t - delay) + disturbance(phase, x)."""

    gain: float = 1.0
    delay: float = 0.0
    P: float = 50.0
    D: float = 14.0
    frequency: float = 1.0
    amplitude: float = 0.02
    disturbance: Callable[[float, float], float] = rich
    step: float = 1e-3

    @property
    def omega(self) -> np.ndarray:
        return 2 * np.pi * self.frequency * np.arange(13.0)

    @property
    def sensitivity(self) -> np.ndarray:
        """1 / (1 + C G) at the harmonics: what the plain sum leaves of an error."""
        s = 1j * self.omega[1:]
        G = self.gain * np.exp(-self.delay * s) / s**2
        return np.abs(np.concatenate(([0.0], 1 / (1 + (self.P + self.D * s) * G))))

    def repeat(self, weights: np.ndarray, laps: int = 8) -> Lap:
        """The last of some laps."""
        count = round(1 / (self.frequency * self.step))
        omega = 2 * np.pi * self.frequency
        phase = 2 * np.pi * np.arange(count) / count
        x_ref, v_ref = self.amplitude * np.sin(phase), self.amplitude * omega * np.cos(phase)
        feedforward = -(omega**2) * x_ref + BASIS.evaluate(phase, weights)[0]
        waiting = [0.0] * round(self.delay / self.step)
        x, v = 0.0, float(v_ref[0])
        error, feedback = np.zeros(count), np.zeros(count)
        for _ in range(laps):
            for i in range(count):
                error[i] = x_ref[i] - x
                feedback[i] = self.P * error[i] + self.D * (v_ref[i] - v)
                waiting.append(feedforward[i] + feedback[i])
                a = self.gain * waiting.pop(0) + self.disturbance(phase[i], x)
                x += v * self.step + a * self.step**2 / 2
                v += a * self.step
        return Lap(phase, feedback[None, :], error[None, :], x_ref[None, :])

    def feedback_of(self, lap: Lap) -> np.ndarray:
        """|C e| by harmonic, by quadrature."""
        assert lap.error is not None
        harmonics = [np.mean(lap.error[0] * np.exp(-1j * n * lap.phase)) for n in range(13)]
        return np.abs((self.P + 1j * self.omega * self.D) * np.array(harmonics))


def fitted(weights: np.ndarray, lap: Lap) -> FittedRepetition:
    found = fit_laps([lap], BASIS)
    assert found.error is not None
    assert found.reference is not None
    return FittedRepetition(weights, found.error, found.reference)


def rms(lap: Lap) -> float:
    assert lap.error is not None
    return float(np.sqrt(np.mean(lap.error**2)))


class Learning:
    """An entry that is learned on a plant."""

    def __init__(self, plant: LinearPlant) -> None:
        self.plant = plant
        self.gains = {"P": [plant.P], "D": [plant.D]}
        parameters = {"amplitude": plant.amplitude, "frequency": plant.frequency}
        self.key = EntryKey.of("r", "squat", "1", ("com.z",), parameters)
        self.entry = Entry(self.key, BASIS, self.circumstances)
        self.errors: list[float] = []
        self.laps: list[Lap] = []

    @property
    def circumstances(self) -> Circumstances:
        return Circumstances(self.gains)

    def repeat(self, rule: str, times: int = 1) -> None:
        for _ in range(times):
            weights = self.entry.served.weights if self.entry.iterations else NOTHING
            lap = self.plant.repeat(weights)
            errors = {"com.z": AxisError(rms(lap))}
            recording = Recording(self.key, BASIS, weights, [lap], errors, self.circumstances)
            self.entry.add(recording, Instruction(find_rule(rule)))
            self.errors.append(rms(lap))
            self.laps.append(lap)


@pytest.mark.parametrize(("gain", "delay"), [(0.85, 0.02), (1.15, 0.02), (1.0, 0.03), (1.1, 0.0)])
def test_the_plain_sum_leaves_of_each_harmonic_what_is_predicted(gain: float, delay: float) -> None:
    plant = LinearPlant(gain, delay)
    before = plant.repeat(NOTHING)
    after = plant.repeat(update_weights(NOTHING, fit_laps([before], BASIS).feedback))
    left = plant.feedback_of(after) / plant.feedback_of(before)
    excited = list(EXCITED)
    np.testing.assert_allclose(left[excited], plant.sensitivity[excited], rtol=0.03)


@pytest.mark.parametrize(
    ("gain", "delay"), [(0.85, 0.02), (1.15, 0.02), (1.0, 0.03), (1.1, 0.0), (0.9, 0.01)]
)
def test_gain_and_delay_are_found_from_three_repetitions(gain: float, delay: float) -> None:
    plant = LinearPlant(gain, delay)
    harmonics = np.zeros((2, 1, 13), dtype=complex)
    harmonics[:, 0, :7] = np.random.default_rng(1).normal(0, 0.2, (2, 7))
    repetitions = [
        fitted(weights, plant.repeat(weights))
        for weights in (NOTHING, *(to_weights(BASIS, each) for each in harmonics))
    ]
    found = estimate_response(
        np.array([to_harmonics(BASIS, each.weights)[0] for each in repetitions]),
        np.array([to_harmonics(BASIS, each.error)[0] for each in repetitions]),
        plant.omega,
        plant.P,
        plant.D,
    )
    assert abs(found.gain - gain) < 2 * found.gain_deviation
    assert abs(found.delay - delay) < 2 * found.delay_deviation
    assert found.gain == pytest.approx(gain, abs=0.06)
    assert found.delay == pytest.approx(delay, abs=0.0035)


def test_with_a_perfect_model_one_repetition_is_enough() -> None:
    # left over is what the assumed delay of 5 ms is wrong by, |1 - exp(j omega 0.005)| at most
    plant = LinearPlant(frequency=0.25)
    before = plant.repeat(NOTHING, laps=3)
    update = update_stably([fitted(NOTHING, before)], BASIS, 0.25, [50.0], [14.0])
    phase = np.linspace(0, 2 * np.pi, 400)
    wanted = [-rich(phi, 0.0) for phi in phase]
    np.testing.assert_allclose(BASIS.evaluate(phase, update.weights)[0], wanted, atol=0.08)
    after = plant.repeat(update.weights, laps=3)
    assert rms(after) < 0.03 * rms(before)


def test_where_the_plain_sum_grows_the_stable_rule_shrinks() -> None:
    plant = LinearPlant(1.0, 0.03)
    grows = plant.sensitivity[5]
    assert grows > 1.5
    plain, stable = Learning(plant), Learning(plant)
    plain.repeat("plain", 7)
    stable.repeat("stable", 7)
    fifth = [plant.feedback_of(lap)[5] for lap in plain.laps]
    np.testing.assert_allclose(np.divide(fifth[1:], fifth[:-1]), grows, rtol=0.02)
    assert plain.errors[6] > 1.3 * min(plain.errors)
    assert stable.errors[6] < 1e-3 * stable.errors[0]
    assert stable.errors[6] < 0.005 * plain.errors[6]
    for lap, before in zip(stable.laps[2:5], stable.laps[1:4], strict=True):
        assert plant.feedback_of(lap)[5] < 0.9 * plant.feedback_of(before)[5]


def test_nothing_grows_again_once_all_is_learned() -> None:
    # repetitions that hardly differ say nothing about the response: it has to be remembered
    learning = Learning(LinearPlant(1.0, 0.03))
    learning.repeat("stable", 14)
    assert max(learning.errors[6:]) < 5e-4 * learning.errors[0]
    assert learning.entry.contractions[0].delay == pytest.approx(0.03, abs=0.004)


def test_the_account_says_beforehand_what_is_observed() -> None:
    plant = LinearPlant(0.85, 0.02)
    learning = Learning(plant)
    learning.repeat("stable", 2)
    (before,) = learning.entry.contractions
    learning.repeat("stable")
    (after,) = learning.entry.contractions
    assert before.axis == "com.z"
    np.testing.assert_allclose(before.frequency, np.arange(13))
    np.testing.assert_allclose(before.plain, plant.sensitivity, atol=0.12)
    for harmonic in EXCITED:
        predicted, observed = before.predicted[harmonic], after.observed[harmonic]
        assert predicted is not None
        assert observed is not None
        assert observed < predicted < 1
        left = plant.feedback_of(learning.laps[2]) / plant.feedback_of(learning.laps[1])
        assert observed == pytest.approx(left[harmonic], rel=0.1)


@pytest.mark.parametrize("stiffness", [2.0, -2.0])
def test_a_spring_that_the_model_does_not_know_is_learned_at_low_gains(stiffness: float) -> None:
    # at P = 5 the robot is decimetres off, and what it needs there is not what it needs
    def spring(phase: float, x: float) -> float:
        return 1.0 - stiffness * x

    plant = LinearPlant(P=5.0, D=4.5, frequency=0.25, amplitude=0.03, disturbance=spring)
    plain, stable = Learning(plant), Learning(plant)
    plain.repeat("plain", 4)
    stable.repeat("stable", 4)
    assert plain.errors[0] > 0.05
    assert stable.errors[3] < 0.001 * plain.errors[3]


def test_the_learning_gain_comes_back_with_success() -> None:
    learning = Learning(LinearPlant(1.0, 0.03))
    learning.repeat("stable", 2)
    entry = learning.entry
    worse = {"com.z": AxisError(1.0)}
    lap = learning.plant.repeat(entry.served.weights)
    made = Recording(
        learning.key, BASIS, entry.served.weights, [lap], worse, learning.circumstances
    )
    entry.add(made, Instruction(find_rule("stable")))
    assert entry.learning_gain == 0.5
    (account,) = entry.contractions
    predicted = [value for value in account.predicted if value is not None]
    assert min(predicted) >= 0.5  # half of the error is left alone
    learning.repeat("stable", 2)  # the best again, then what was learned from it
    assert learning.errors[-1] < 0.7 * learning.errors[-2]
    assert entry.learning_gain == 1.0


def test_gains_changed_midway_start_from_what_was_learned() -> None:
    learning = Learning(LinearPlant(1.0, 0.02))
    learning.repeat("stable", 3)
    softer = Learning(LinearPlant(1.0, 0.02, P=20.0, D=9.0))
    learning.plant, learning.gains = softer.plant, softer.gains
    softer.repeat("stable")
    learning.repeat("stable", 3)
    # the feedforward does not depend on the gains of the feedback
    assert learning.errors[3] < 0.05 * softer.errors[0]
    assert learning.errors[-1] <= learning.errors[3]
    observed = learning.entry.observed_contractions()
    assert observed is not None
    assert len(observed) == 4  # not across the change
