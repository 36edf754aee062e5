from __future__ import annotations

import math

import numpy as np
import pinocchio
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation

from tsd_casadi import Controller, InverseDynamics, Robot, Status, load_robot
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.hold import hold
from tsd_casadi.robot.standing import COMFORT, stand, standing_heights
from tsd_casadi.tick.command import Command

HERMES = load_robot("hermes_lower")
HEIGHTS = st.floats(-0.12, 0.12)


def held(robot: Robot, q: np.ndarray) -> np.ndarray:
    """What standing keeps: soles, base orientation, centre of mass; against home."""
    rest = []
    for contact in robot.description.contacts:
        now, then = (robot.frame_placement(contact.frame, x) for x in (q, robot.home.q))
        rest += [now[0] - then[0], turn(now[1], then[1])]
    rest += [turn(q[3:7], robot.home.q[3:7]), robot.center_of_mass(q) - robot.home_com]
    return np.concatenate(rest)


def turn(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.asarray((Rotation.from_quat(other).inv() * Rotation.from_quat(one)).as_rotvec())


@settings(max_examples=settings.default.max_examples // 4)
@given(height=HEIGHTS)
def test_soles_and_base_stay_and_the_centre_of_mass_rises_straight(height: float) -> None:
    state = stand(HERMES, height)
    expected = np.zeros(18)
    expected[-1] = height
    np.testing.assert_allclose(held(HERMES, state.q), expected, atol=1e-8)
    assert not state.v.any()


@settings(max_examples=settings.default.max_examples // 4)
@given(height=HEIGHTS)
def test_joints_stay_inside_their_limits(height: float) -> None:
    q = stand(HERMES, height).q[7:]
    assert (HERMES.model.lowerPositionLimit[7:] <= q).all()
    assert (q <= HERMES.model.upperPositionLimit[7:]).all()


@pytest.mark.parametrize("height", [-0.05, 0.03, 0.06, 0.12])
def test_no_posture_nearby_is_nearer_to_home(robot: Robot, height: float) -> None:
    q = stand(robot, height).q
    step = 1e-6
    J = np.transpose(
        [
            (held(robot, pinocchio.integrate(robot.model, q, sign)) - held(robot, q)) / step
            for sign in step * np.eye(robot.nv)
        ]
    )
    free = null_space(J, rcond=1e-4)
    assert free.shape == (robot.nv, robot.nv - 18)
    homeward = pinocchio.difference(robot.model, q, robot.home.q)
    np.testing.assert_allclose(free.T @ homeward, 0, atol=1e-5)


def test_a_smooth_function_of_the_height() -> None:
    heights = np.linspace(-0.1, 0.1, 41)
    knee = 7 + HERMES.joint_names.index("L_KFE")
    angles = np.array([stand(HERMES, height).q[knee] for height in heights])
    assert (np.diff(angles) < 0).all()
    assert np.abs(np.diff(angles, 2)).max() < 5e-3


def test_zero_is_home(robot: Robot) -> None:
    np.testing.assert_array_equal(stand(robot, 0.0).q, robot.home.q)
    np.testing.assert_allclose(stand(robot, 1e-9).q, robot.home.q, atol=1e-7)


@pytest.mark.parametrize("height", [0.14, 0.2, 0.5, 1.0, 1e9, -0.5, -0.7, -1e9, math.inf, math.nan])
def test_impossible_heights_are_refused(robot: Robot, height: float) -> None:
    with pytest.raises(InvalidValue, match="a height that hermes_lower can stand at") as caught:
        stand(robot, height)
    assert caught.value.field == "height"


def test_what_only_the_joint_limits_forbid_is_refused(mini_biped: Robot) -> None:
    # this robot's legs are sliders: nothing but their ends stops it
    slide = 7 + mini_biped.joint_names.index("near_slide")
    room = mini_biped.model.upperPositionLimit[slide] - mini_biped.home.q[slide]
    # the centre of mass rises by less than the legs grow
    assert stand(mini_biped, 0.5 * room).q[slide] < mini_biped.model.upperPositionLimit[slide]
    with pytest.raises(InvalidValue, match="mini_biped"):
        stand(mini_biped, 1.2 * room)


def test_holding_home_is_the_default(problem: InverseDynamics, robot: Robot) -> None:
    command = Command(problem.request)
    hold(command, robot, robot.home)
    np.testing.assert_allclose(command.request, problem.request.defaults(), atol=1e-12)


def test_holding_sets_references_and_nothing_else(problem: InverseDynamics, robot: Robot) -> None:
    command = Command(problem.request)
    hold(command, robot, stand(robot, 0.04))
    changed = {
        problem.request.locate(int(index))[0].name
        for index in np.flatnonzero(np.abs(command.request - problem.request.defaults()) > 1e-6)
    }
    assert changed <= {"com.reference", "pelvis.reference", "torso.reference", "posture.q_ref"}
    assert {"com.reference", "posture.q_ref"} <= changed


@pytest.mark.parametrize("height", [-0.05, 0.05])
def test_the_controller_has_nothing_to_do_in_a_held_posture(
    controller: Controller, robot: Robot, height: float
) -> None:
    posture = stand(robot, height)
    command = controller.command()
    hold(command, robot, posture)
    tick = controller.tick(posture, command)
    assert tick.status == Status.OK
    np.testing.assert_allclose(tick.error, 0, atol=1e-8)
    np.testing.assert_allclose(tick.qdd, 0, atol=1e-3)
    # in the default command it has
    assert np.abs(controller.tick(posture, controller.command()).error).max() > 0.04


def test_comfortable_heights_are_a_share_of_those_in_reach(any_robot: Robot) -> None:
    low, high = standing_heights(any_robot)
    assert low < -0.03 < 0.03 < high
    for height in (low, high):
        stand(any_robot, height)
        stand(any_robot, height / COMFORT)
        with pytest.raises(InvalidValue, match="height"):
            stand(any_robot, height / COMFORT * (1 + 2e-3 / abs(height)))


def test_holds_what_the_robot_file_calls_a_posture(controller: Controller, robot: Robot) -> None:
    tall = robot.posture("tall")
    command = controller.command()
    hold(command, robot, tall)
    tick = controller.tick(tall, command)
    assert tick.status == Status.OK
    np.testing.assert_allclose(tick.error, 0, atol=1e-8)
