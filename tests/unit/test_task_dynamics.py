from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tsd_casadi.encoding.harmonics import sample_phases
from tsd_casadi.learning.task_dynamics import shift_to_reference

PHI = sample_phases()
REFERENCE = 0.05 * np.sin(PHI)
BELOW = np.full_like(PHI, 0.01)


@pytest.mark.parametrize("k", [20.0, 5.0, -10.0])
@pytest.mark.parametrize("error", [BELOW, BELOW + 0.005 * np.sin(2 * PHI)])
def test_a_spring_is_shifted_by_stiffness_times_error(k: float, error: np.ndarray) -> None:
    position = REFERENCE - error
    shift = shift_to_reference(PHI, [position], [3.0 + k * position], REFERENCE)
    np.testing.assert_allclose(shift, k * error, atol=0.03 * np.abs(k * error).max())


def test_a_curved_law_is_followed() -> None:
    def law(x: np.ndarray) -> np.ndarray:
        return 2 * np.sin(x / 0.04)

    position = REFERENCE - BELOW
    shift = shift_to_reference(PHI, [position], [law(position)], REFERENCE)
    inside = position.max() > REFERENCE  # elsewhere it is a guess
    expected = law(REFERENCE) - law(position)
    np.testing.assert_allclose(shift[inside], expected[inside], atol=0.1 * np.abs(expected).max())


@pytest.mark.parametrize("wave", [np.cos(PHI), np.sin(2 * PHI), np.cos(3 * PHI)])
def test_what_differs_on_the_way_up_and_down_is_no_matter_of_position(wave: np.ndarray) -> None:
    shift = shift_to_reference(PHI, [REFERENCE - BELOW], [0.5 * wave], REFERENCE)
    assert np.abs(shift).max() < 1e-3


def test_what_stays_the_same_elsewhere_is_no_matter_of_position() -> None:
    # one repetition cannot tell sin(phi) from a spring, a second one elsewhere can
    wave = 0.5 * np.sin(PHI)
    one = shift_to_reference(PHI, [REFERENCE - BELOW], [wave], REFERENCE)
    two = shift_to_reference(PHI, [REFERENCE - 2 * BELOW, REFERENCE - BELOW], [wave] * 2, REFERENCE)
    assert np.abs(one).max() > 0.05
    assert np.abs(two).max() < 1e-3


def test_noise_is_hardly_taken_for_a_law() -> None:
    noise = 0.5 * np.random.default_rng(0).normal(size=PHI.shape)
    shift = shift_to_reference(PHI, [REFERENCE - BELOW], [noise], REFERENCE)
    assert np.abs(shift).max() < 0.05


def test_at_the_reference_there_is_nothing_to_shift() -> None:
    shift = shift_to_reference(PHI, [REFERENCE], [5 * REFERENCE], REFERENCE)
    np.testing.assert_allclose(shift, 0, atol=1e-9)


@settings(max_examples=settings.default.max_examples // 12)
@given(offset=st.floats(-5.0, 5.0), moved=st.floats(-1.0, 1.0))
def test_neither_a_constant_nor_the_origin_matters(offset: float, moved: float) -> None:
    position, a = REFERENCE - BELOW, np.sin(PHI) + 0.1 * np.cos(2 * PHI)
    expected = shift_to_reference(PHI, [position], [a], REFERENCE)
    found = shift_to_reference(PHI, [position + moved], [a + offset], REFERENCE + moved)
    np.testing.assert_allclose(found, expected, atol=1e-4)
