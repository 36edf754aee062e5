from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.encoding.phase_oscillator import PhaseOscillator

DT = 1e-3


def test_phase_grows_by_omega_dt() -> None:
    oscillator = PhaseOscillator(0.25, math.pi)
    assert oscillator.omega == pytest.approx(math.pi / 2)
    assert (oscillator.phase, oscillator.elapsed, oscillator.lap) == (math.pi, 0.0, 0)
    oscillator.advance(0.4)
    assert oscillator.phase == pytest.approx(math.pi + 0.2 * math.pi)
    assert oscillator.elapsed == pytest.approx(0.2 * math.pi)


@pytest.mark.parametrize("frequency", [0.05, 0.1, 0.25, 0.5, 1.0])
def test_laps_of_whole_ticks_all_have_the_same_number(frequency: float) -> None:
    oscillator = PhaseOscillator(frequency, math.pi)
    ticks = [0] * 6
    while oscillator.lap < 6:
        ticks[oscillator.lap] += 1
        oscillator.advance(DT)
    assert ticks == [round(1 / frequency / DT)] * 6


@given(frequency=st.floats(0.05, 1.0), start=st.floats(0, 7))
def test_a_lap_is_the_ticks_of_one_period_up_to_one(frequency: float, start: float) -> None:
    oscillator = PhaseOscillator(frequency, start)
    count = 0
    while oscillator.lap == 0:
        oscillator.advance(0.01)
        count += 1
    assert 100 / frequency - 1e-6 <= count <= 100 / frequency + 1


def test_frequency_may_change_without_a_jump_of_phase() -> None:
    oscillator = PhaseOscillator(0.25, 0.0)
    oscillator.advance(1.0)
    before = oscillator.phase
    oscillator.frequency = 1.0
    assert oscillator.phase == before
    oscillator.advance(0.25)
    assert oscillator.phase == pytest.approx(before + math.pi / 2)
