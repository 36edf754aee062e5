from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.learning.learning_filter import CAUTION, LARGEST_CONTRACTION, design_filter
from tsd_casadi.learning.loop_response import LoopResponse

P, D = 50.0, 14.0
HARMONIC = np.arange(13.0)


def omega_of(frequency: float) -> np.ndarray:
    return 2 * np.pi * frequency * HARMONIC


def test_the_filter_inverts_the_loop_it_was_designed_for() -> None:
    response, omega = LoopResponse(0.9, 0.02), omega_of(0.5)
    found = design_filter(response, omega, P, D)
    np.testing.assert_allclose(found.L * response.transfer(omega, P, D), 1, atol=1e-12)
    assert found.lead == response.delay
    assert found.contraction.max() < 1e-12


def test_known_loop_is_learned_at_once() -> None:
    # a repetition of the loop with a disturbance d: e = -d / (G C + s^2)
    response, omega = LoopResponse(1.0, 0.0, 0.01, 0.001), omega_of(0.5)
    rng = np.random.default_rng(0)
    d = rng.normal(size=13) + 1j * rng.normal(size=13)
    C = P + 1j * omega * D
    error = -d / (C - omega**2)
    after = design_filter(response, omega, P, D).apply(np.zeros(13), C * error)
    np.testing.assert_allclose(after, -d, rtol=1e-10)


def test_slow_harmonics_are_learned_as_by_the_plain_sum() -> None:
    omega = omega_of(0.1)
    found = design_filter(LoopResponse(), omega, P, D)
    assert found.L[0] == 1
    assert found.Q.all()
    np.testing.assert_allclose(found.L[:4], 1, atol=0.07)
    np.testing.assert_allclose(np.abs(found.L - 1), omega**2 / np.abs(P + 1j * omega * D))


def test_plain_contraction_is_the_sensitivity() -> None:
    omega = omega_of(1.0)
    found = design_filter(LoopResponse(1.0, 0.03), omega, P, D)
    G = np.exp(-0.03j * omega[1:]) / (1j * omega[1:]) ** 2
    expected = 1 / np.abs(1 + (P + 1j * omega[1:] * D) * G)
    np.testing.assert_allclose(found.plain_contraction[1:], expected, rtol=1e-10)
    assert found.plain_contraction[0] == 0
    assert expected.max() > 1.5  # what the plain sum lets grow


def test_uncertain_delay_cuts_the_bandwidth_where_learning_may_diverge() -> None:
    omega = omega_of(1.0)
    found = design_filter(LoopResponse(1.0, 0.03, 0.1, 0.01), omega, P, D)
    left = [
        np.abs(1 - found.L * LoopResponse(gain, delay).transfer(omega, P, D))
        for gain in np.linspace(0.8, 1.2, 21)
        for delay in np.linspace(0.01, 0.05, 21)
    ]
    first = int(np.argmax(np.max(left, axis=0) >= LARGEST_CONTRACTION))
    assert 1 < first < 12
    np.testing.assert_array_equal(found.Q, first > HARMONIC)
    assert found.bandwidth == pytest.approx(first - 1.0)
    known = design_filter(LoopResponse(1.0, 0.03, 0.02, 0.002), omega, P, D)
    assert known.Q.all()


def test_nothing_above_the_bandwidth_is_fed_forward() -> None:
    found = design_filter(LoopResponse(1.0, 0.03, 0.1, 0.02), omega_of(1.0), P, D)
    cut = found.Q == 0
    assert cut.any()
    assert not found.apply(np.ones(13), np.ones(13))[cut].any()


def test_the_mean_is_always_learned() -> None:
    found = design_filter(LoopResponse(1.0, 0.1, 0.4, 0.1), omega_of(1.0), P, D)
    assert found.Q[0] == 1
    assert found.bandwidth == 0


@given(
    gain=st.floats(0.7, 1.3),
    delay=st.floats(0.0, 0.03),
    deviations=st.tuples(st.floats(0.001, 0.1), st.floats(1e-4, 0.006)),
    off=st.tuples(st.floats(-CAUTION, CAUTION), st.floats(-CAUTION, CAUTION)),
    frequency=st.floats(0.1, 1.0),
    stiffness=st.floats(3.0, 200.0),
    damping_ratio=st.floats(0.3, 1.5),
)
def test_whatever_the_loop_is_within_the_caution_all_that_is_learned_contracts(
    gain: float,
    delay: float,
    deviations: tuple[float, float],
    off: tuple[float, float],
    frequency: float,
    stiffness: float,
    damping_ratio: float,
) -> None:
    damping, omega = 2 * damping_ratio * np.sqrt(stiffness), omega_of(frequency)
    found = design_filter(LoopResponse(gain, delay, *deviations), omega, stiffness, damping)
    real = LoopResponse(gain + off[0] * deviations[0], delay + off[1] * deviations[1])
    contraction = found.Q * np.abs(1 - found.L * real.transfer(omega, stiffness, damping))
    assert (contraction <= found.worst_contraction + 1e-6).all()
    assert (contraction < LARGEST_CONTRACTION + 1e-6).all()
