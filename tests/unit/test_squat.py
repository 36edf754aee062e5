from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tsd_casadi as tsd
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.squat import Squat

ELAPSED = st.floats(0.0, 40.0)
AMPLITUDES = st.floats(0.001, 0.08)
FREQUENCIES = st.floats(0.05, 1.0)


@given(elapsed=ELAPSED, amplitude=AMPLITUDES, frequency=FREQUENCIES)
def test_derivatives_agree_with_finite_differences(
    elapsed: float, amplitude: float, frequency: float
) -> None:
    squat = Squat(amplitude, frequency)
    omega = 2 * math.pi * frequency
    # central differences over phase; at the very start only forward times exist
    step = 1e-4
    middle = elapsed + step
    before, now, after = (squat.reference(middle + shift) for shift in (-step, 0.0, step))
    rate = omega / (2 * step)
    # errors: third derivative of a quintic start, at most about 60 / pi^3 per rad^3
    assert now.xd == pytest.approx((after.x - before.x) * rate, abs=1e-6 * amplitude * omega)
    assert now.xdd == pytest.approx((after.xd - before.xd) * rate, abs=1e-3 * amplitude * omega**2)


@pytest.mark.parametrize("frequency", [0.05, 0.25, 1.0])
def test_starts_at_home_at_rest_without_a_jerk(frequency: float) -> None:
    start = Squat(0.05, frequency).reference(0.0)
    assert (start.x, start.xd, start.xdd) == (0.0, 0.0, 0.0)


@given(boundary=st.sampled_from([0.0, math.pi]), amplitude=AMPLITUDES, frequency=FREQUENCIES)
def test_no_jump_where_the_start_ends(boundary: float, amplitude: float, frequency: float) -> None:
    squat = Squat(amplitude, frequency)
    omega = 2 * math.pi * frequency
    one, other = squat.reference(boundary), squat.reference(boundary + 1e-9)
    assert other.x == pytest.approx(one.x, abs=1e-7 * amplitude)
    assert other.xd == pytest.approx(one.xd, abs=1e-7 * amplitude * omega)
    assert other.xdd == pytest.approx(one.xdd, abs=1e-7 * amplitude * omega**2)


@given(elapsed=st.floats(1e-3, math.pi - 1e-3), amplitude=AMPLITUDES)
def test_first_motion_is_down(elapsed: float, amplitude: float) -> None:
    assert Squat(amplitude, 0.25).reference(elapsed).x < 0


@given(elapsed=st.floats(math.pi, 50.0), amplitude=AMPLITUDES, frequency=FREQUENCIES)
def test_after_half_a_lap_it_is_a_sin_phase(
    elapsed: float, amplitude: float, frequency: float
) -> None:
    squat = Squat(amplitude, frequency)
    phase, omega = squat.start_phase + elapsed, 2 * math.pi * frequency
    reference = squat.reference(elapsed)
    assert reference.x == pytest.approx(amplitude * math.sin(phase), abs=1e-12)
    assert reference.xd == pytest.approx(amplitude * omega * math.cos(phase), abs=1e-11)
    assert reference.xdd == pytest.approx(-amplitude * omega**2 * math.sin(phase), abs=1e-10)


def test_amplitude_is_half_of_peak_to_peak() -> None:
    squat = Squat(0.05, 0.25)
    heights = [squat.reference(elapsed).x for elapsed in np.linspace(7, 7 + 2 * np.pi, 1001)]
    assert max(heights) - min(heights) == pytest.approx(0.10, abs=1e-6)


@given(elapsed=ELAPSED, amplitude=AMPLITUDES)
def test_never_leaves_the_amplitude(elapsed: float, amplitude: float) -> None:
    assert abs(Squat(amplitude, 0.25).reference(elapsed).x) <= amplitude


def test_parameters_name_task_and_axis(robot: tsd.Robot) -> None:
    squat = Squat(amplitude=0.03, frequency=0.25, height=-0.02)
    assert squat.parameters == {"amplitude": 0.03, "frequency": 0.25, "height": -0.02}
    assert Squat(0.03, 0.25).parameters["height"] == 0.0
    assert (squat.name, squat.axis, squat.task(robot)) == ("squat", "z", "com")


@pytest.mark.parametrize("amplitude", [0.001, 0.03, 0.08])
@pytest.mark.parametrize("frequency", [0.05, 0.25, 1.0])
def test_the_robots_range_is_accepted_to_its_ends(
    robot: tsd.Robot, amplitude: float, frequency: float
) -> None:
    Squat(amplitude, frequency).check(robot)


@pytest.mark.parametrize("amplitude", [0.0, 0.0009, 0.0801, -0.03, math.nan, math.inf])
def test_amplitude_out_of_range_is_refused(robot: tsd.Robot, amplitude: float) -> None:
    with pytest.raises(InvalidValue, match=r"0\.001 to 0\.08 m for hermes_lower") as caught:
        Squat(amplitude, 0.25).check(robot)
    assert caught.value.field == "amplitude"
    assert "did you mean" not in str(caught.value)


@pytest.mark.parametrize(
    ("given_value", "meant"),
    [
        (5.0, "0.05 or 0.005"),
        (0.5, "0.05 or 0.005"),
        (30.0, "0.03"),
        (8, "0.08 or 0.008"),
        (0.9, "0.009"),
    ],
)
def test_whatever_a_length_may_have_meant_is_asked_for(
    robot: tsd.Robot, given_value: float, meant: str
) -> None:
    with pytest.raises(InvalidValue, match=rf": did you mean {meant} m\?$"):
        Squat(given_value, 0.25).check(robot)


@pytest.mark.parametrize(
    ("height", "meant"), [(0.5, "0.05 or 0.005 or 0.0005"), (-3, "-0.03 or -0.003")]
)
def test_the_same_of_a_height(robot: tsd.Robot, height: float, meant: str) -> None:
    with pytest.raises(InvalidValue, match=rf": did you mean {meant} m\?$"):
        Squat(0.03, 0.25, height).check(robot)


@pytest.mark.parametrize("frequency", [0.0, 0.049, 1.01, -0.25, math.nan, math.inf, 5.0])
def test_frequency_out_of_range_is_refused(robot: tsd.Robot, frequency: float) -> None:
    with pytest.raises(InvalidValue, match=r"0\.05 to 1 Hz for hermes_lower") as caught:
        Squat(0.03, frequency).check(robot)
    assert caught.value.field == "frequency"
    assert "did you mean" not in str(caught.value)


@pytest.mark.parametrize("height", [-0.05, -0.02, 0.0, 0.06])
def test_the_middle_is_that_much_above_home(robot: tsd.Robot, height: float) -> None:
    squat = Squat(0.03, 0.25, height)
    squat.check(robot)
    middle = squat.middle(robot)
    raised = robot.center_of_mass(middle.q) - robot.home_com
    np.testing.assert_allclose(raised, [0, 0, height], atol=1e-9)
    assert not middle.v.any()
    # the reference is relative to it
    assert squat.reference(8.0) == Squat(0.03, 0.25).reference(8.0)


@pytest.mark.parametrize("height", [-0.051, 0.061, math.nan, math.inf])
def test_height_out_of_range_is_refused(robot: tsd.Robot, height: float) -> None:
    with pytest.raises(InvalidValue, match=r"-0\.05 to 0\.06 m for hermes_lower") as caught:
        Squat(0.03, 0.25, height).check(robot)
    assert caught.value.field == "height"
