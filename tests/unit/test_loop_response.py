from __future__ import annotations

import numpy as np
import pytest
import scipy.signal
from hypothesis import given, settings
from hypothesis import strategies as st

from tsd_casadi.learning.loop_response import LoopResponse, estimate_response

P, D = 50.0, 14.0
OMEGA = 2 * np.pi * np.arange(13.0)
C = P + 1j * OMEGA * D


def linear_repetitions(
    gain: float, delay: float, seed: int, count: int = 2
) -> tuple[np.ndarray, np.ndarray]:
    """Feedforward and errors that obey the linear equation exactly."""
    rng = np.random.default_rng(seed)
    u = rng.normal(size=(count, 13)) + 1j * rng.normal(size=(count, 13))
    G = gain * np.exp(-1j * OMEGA * delay)
    # 0 = G (u + C e) - omega^2 e + d
    return u, (-G * u - rng.normal(size=13)) / (G * C - OMEGA**2)


def test_transfer_is_scipys_closed_loop() -> None:
    loop = scipy.signal.TransferFunction([0.9 * D, 0.9 * P], [1, 0.9 * D, 0.9 * P])
    _, expected = scipy.signal.freqresp(loop, OMEGA[1:])
    found = LoopResponse(gain=0.9, delay=0.0).transfer(OMEGA, P, D)
    np.testing.assert_allclose(found[1:], expected, rtol=1e-12)
    assert found[0] == 1


def test_delay_turns_the_open_loop() -> None:
    prompt, late = (LoopResponse(1.0, delay).transfer(OMEGA, P, D) for delay in (0.0, 0.02))
    open_prompt, open_late = (T[1:] / (1 - T[1:]) for T in (prompt, late))
    np.testing.assert_allclose(open_late, open_prompt * np.exp(-0.02j * OMEGA[1:]), rtol=1e-9)


def test_one_repetition_tells_nothing() -> None:
    u, e = linear_repetitions(0.8, 0.03, seed=0)
    assert estimate_response(u[:1], e[:1], OMEGA, P, D) == LoopResponse()


def test_the_same_repetition_twice_tells_nothing() -> None:
    u, e = linear_repetitions(0.8, 0.03, seed=0)
    found = estimate_response(u[[0, 0]], e[[0, 0]], OMEGA, P, D)
    np.testing.assert_allclose(list(vars(found).values()), list(vars(LoopResponse()).values()))


@settings(max_examples=settings.default.max_examples // 3)
@given(
    gain=st.floats(0.8, 1.2),
    delay=st.floats(0.0, 0.035),
    seed=st.integers(0, 100),
    count=st.integers(2, 5),
)
def test_what_obeys_the_equation_is_found(gain: float, delay: float, seed: int, count: int) -> None:
    found = estimate_response(*linear_repetitions(gain, delay, seed, count), OMEGA, P, D)
    assert found.gain == pytest.approx(gain, abs=1e-3)
    assert found.delay == pytest.approx(delay, abs=1e-4)


def test_what_no_response_explains_makes_less_certain() -> None:
    u, e = linear_repetitions(0.8, 0.03, seed=0)
    rng = np.random.default_rng(3)
    mixed = e * (1 + 0.2 * rng.normal(size=e.shape))
    clear, doubtful = (estimate_response(u, each, OMEGA, P, D) for each in (e, mixed))
    assert doubtful.delay_deviation > 2 * clear.delay_deviation
    assert doubtful.gain_deviation > 2 * clear.gain_deviation
    assert abs(clear.delay - 0.03) < abs(doubtful.delay - 0.03)


@pytest.mark.parametrize("spring", [-6.0, 2.0, 8.0])
def test_a_spring_is_not_taken_for_another_gain(spring: float) -> None:
    # d = -spring x in 0 = G (u + C e) - omega^2 e + spring e, slow enough to matter
    omega = 2 * np.pi * 0.25 * np.arange(13.0)
    rng = np.random.default_rng(0)
    u = rng.normal(size=(3, 13)) + 1j * rng.normal(size=(3, 13))
    G = np.exp(-1j * omega * 0.005)
    e = -G * u / (G * (10.0 + 6j * omega) - omega**2 + spring)
    found = estimate_response(u, e, omega, 10.0, 6.0)
    assert found.gain == pytest.approx(1.0, abs=0.02)
