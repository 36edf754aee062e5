"""The squat; what holds for every motion is in test_motions.py."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tsd_casadi as tsd
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.ranges import check_motion
from tsd_casadi.motions.squat import Squat

ELAPSED = st.floats(0.0, 40.0)
AMPLITUDES = st.floats(0.001, 0.08)
FREQUENCIES = st.floats(0.05, 1.0)


@given(elapsed=st.floats(1e-3, math.pi - 1e-3), amplitude=AMPLITUDES)
def test_first_motion_is_down(elapsed: float, amplitude: float) -> None:
    assert Squat(amplitude, 0.25).reference(elapsed).x[0] < 0


@given(elapsed=st.floats(math.pi, 50.0), amplitude=AMPLITUDES, frequency=FREQUENCIES)
def test_after_half_a_lap_it_is_a_sin_phase(
    elapsed: float, amplitude: float, frequency: float
) -> None:
    squat = Squat(amplitude, frequency)
    phase, omega = squat.start_phase + elapsed, 2 * math.pi * frequency
    reference = squat.reference(elapsed)
    assert reference.x == pytest.approx([amplitude * math.sin(phase)], abs=1e-12)
    assert reference.xd == pytest.approx([amplitude * omega * math.cos(phase)], abs=1e-11)
    assert reference.xdd == pytest.approx([-amplitude * omega**2 * math.sin(phase)], abs=1e-10)


def test_amplitude_is_half_of_peak_to_peak() -> None:
    squat = Squat(0.05, 0.25)
    heights = [squat.reference(elapsed).x[0] for elapsed in np.linspace(7, 7 + 2 * np.pi, 1001)]
    assert max(heights) - min(heights) == pytest.approx(0.10, abs=1e-6)


@given(elapsed=ELAPSED, amplitude=AMPLITUDES)
def test_never_leaves_the_amplitude(elapsed: float, amplitude: float) -> None:
    assert abs(Squat(amplitude, 0.25).reference(elapsed).x[0]) <= amplitude


def test_parameters_name_task_and_axis(robot: tsd.Robot) -> None:
    squat = Squat(amplitude=0.03, frequency=0.25, height=-0.02)
    assert squat.parameters == {"amplitude": 0.03, "frequency": 0.25, "height": -0.02}
    assert Squat(0.03, 0.25).parameters["height"] == 0.0
    assert (squat.name, squat.axes(robot)) == ("squat", ("com.z",))


@pytest.mark.parametrize("amplitude", [0.001, 0.03, 0.08])
@pytest.mark.parametrize("frequency", [0.05, 0.25, 1.0])
def test_the_robots_range_is_accepted_to_its_ends(
    robot: tsd.Robot, amplitude: float, frequency: float
) -> None:
    check_motion(robot, Squat(amplitude, frequency))


@pytest.mark.parametrize("amplitude", [0.0, 0.0009, 0.0801, -0.03, math.nan, math.inf])
def test_amplitude_out_of_range_is_refused(robot: tsd.Robot, amplitude: float) -> None:
    with pytest.raises(InvalidValue, match=r"0\.001 to 0\.08 m for hermes_lower") as caught:
        check_motion(robot, Squat(amplitude, 0.25))
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
        check_motion(robot, Squat(given_value, 0.25))


@pytest.mark.parametrize(
    ("height", "meant"), [(0.5, "0.05 or 0.005 or 0.0005"), (-3, "-0.03 or -0.003")]
)
def test_the_same_of_a_height(robot: tsd.Robot, height: float, meant: str) -> None:
    with pytest.raises(InvalidValue, match=rf": did you mean {meant} m\?$"):
        check_motion(robot, Squat(0.03, 0.25, height))


@pytest.mark.parametrize("frequency", [0.0, 0.049, 1.01, -0.25, math.nan, math.inf, 5.0])
def test_frequency_out_of_range_is_refused(robot: tsd.Robot, frequency: float) -> None:
    with pytest.raises(InvalidValue, match=r"0\.05 to 1 Hz for hermes_lower") as caught:
        check_motion(robot, Squat(0.03, frequency))
    assert caught.value.field == "frequency"
    assert "did you mean" not in str(caught.value)


@pytest.mark.parametrize("height", [-0.05, -0.02, 0.0, 0.06])
def test_the_middle_is_that_much_above_home(robot: tsd.Robot, height: float) -> None:
    squat = Squat(0.03, 0.25, height)
    check_motion(robot, squat)
    middle = squat.middle(robot)
    raised = robot.center_of_mass(middle.q) - robot.home_com
    np.testing.assert_allclose(raised, [0, 0, height], atol=1e-9)
    assert not middle.v.any()
    # the reference is relative to it
    assert squat.reference(8.0).x == Squat(0.03, 0.25).reference(8.0).x


@pytest.mark.parametrize("height", [-0.051, 0.061, math.nan, math.inf])
def test_height_out_of_range_is_refused(robot: tsd.Robot, height: float) -> None:
    with pytest.raises(InvalidValue, match=r"-0\.05 to 0\.06 m for hermes_lower") as caught:
        check_motion(robot, Squat(0.03, 0.25, height))
    assert caught.value.field == "height"
