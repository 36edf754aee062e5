from __future__ import annotations

import copy
import math

import mujoco
import numpy as np
import pinocchio
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import null_space

from tsd_casadi import Robot, State
from tsd_casadi.exceptions import InvalidValue, RobotFileError
from tsd_casadi.robot.foot import feet_jacobian
from tsd_casadi.robot.robot_file_sections import HardwareFile
from tsd_clients import MujocoSimulator
from tsd_clients.simulator.base_estimator import make_base_estimator
from tsd_clients.simulator.effects import (
    ACTUATOR_EFFECTS,
    EFFECTS,
    SENSOR_EFFECTS,
    check_effects,
)
from tsd_clients.simulator.hardware import (
    Actuators,
    Encoders,
    FlatFeetEstimator,
    add_to_model,
)
from tsd_clients.simulator.still_points import StillPointsEstimator

DT = 1e-3
NUMBERS = HardwareFile(
    armature=0.05,
    viscous_friction=0.5,
    coulomb_friction=2.0,
    torque_lag=0.008,
    torque_delay=0.003,
    encoder_resolution=1e-4,
    encoder_noise=2e-5,
    velocity_filter=0.005,
)


def encoders(*effects: str, seed: int = 0) -> Encoders:
    return Encoders(NUMBERS, effects, DT, np.random.default_rng(seed))


# names


def test_effects_come_in_their_usual_order(robot: Robot) -> None:
    assert check_effects(robot, []) == ()
    assert check_effects(robot, ["noise", "friction", "noise"]) == ("friction", "noise")
    assert check_effects(robot, ["all"]) == EFFECTS == (*ACTUATOR_EFFECTS, *SENSOR_EFFECTS)
    assert check_effects(robot, ["lag", "all"]) == EFFECTS


@pytest.mark.parametrize("effects", [["rust"], ["all", "rust"], ["friction", "rust"], ["rust,lag"]])
def test_unknown_effects_are_refused_with_the_known_ones(robot: Robot, effects: list[str]) -> None:
    with pytest.raises(InvalidValue, match=r"hardware is rust.* flat_feet"):
        check_effects(robot, effects)


def test_effects_without_numbers_are_refused(mini_biped: Robot) -> None:
    assert check_effects(mini_biped, []) == ()
    with pytest.raises(RobotFileError, match="'hardware': is missing") as caught:
        MujocoSimulator(mini_biped, hardware=["friction"])
    assert caught.value.path == mini_biped.path


# actuators


@pytest.mark.parametrize(
    ("effects", "delay", "lag"),
    [
        (["delay", "lag"], 3, 0.008),
        (["lag"], 0, 0.008),
        (["delay"], 3, 0.0),
        (["friction", "noise"], 0, 0.0),
    ],
)
def test_step_response_is_that_of_delay_and_first_order_lag(
    effects: list[str], delay: int, lag: float
) -> None:
    actuators = Actuators(NUMBERS, effects, DT)
    low, high = np.array([1.0, -3.0]), np.array([2.0, 5.0])
    for _ in range(5):
        # it stood like that for long
        np.testing.assert_array_equal(actuators.apply(low), low)
    for tick in range(1, 60):
        since = (tick - delay) * DT
        rise = 0.0 if since <= 0 else 1.0 if lag == 0 else 1 - math.exp(-since / lag)
        np.testing.assert_allclose(actuators.apply(high), low + rise * (high - low), atol=1e-12)


@given(torques=st.lists(st.floats(-300, 300), min_size=1, max_size=30))
def test_torques_are_applied_as_they_are_without_an_effect(torques: list[float]) -> None:
    actuators = Actuators(NUMBERS, [], DT)
    for torque in torques:
        assert actuators.apply(np.array([torque])) == [torque]


@given(torques=st.lists(st.floats(-300, 300), min_size=1, max_size=30))
def test_the_applied_torque_never_leaves_the_range_of_the_commands(torques: list[float]) -> None:
    actuators = Actuators(NUMBERS, EFFECTS, DT)
    applied = [float(actuators.apply(np.array([torque]))[0]) for torque in torques]
    assert min(torques) - 1e-9 <= min(applied)
    assert max(applied) <= max(torques) + 1e-9


def test_a_command_may_be_overwritten_after_it_was_given() -> None:
    actuators, tau = Actuators(NUMBERS, ["delay"], DT), np.array([1.0])
    actuators.apply(tau)
    tau[:] = 99.0
    assert actuators.apply(np.array([2.0])) == [1.0]


# encoders


def test_encoders_without_an_effect_tell_the_truth() -> None:
    angles, velocities = np.array([0.1, -0.2]), np.array([3.0, -4.0])
    measured = encoders().measure(angles, velocities)
    np.testing.assert_array_equal(measured, (angles, velocities))


@given(angle=st.floats(-3.0, 3.0))
def test_angles_come_in_steps_and_are_the_nearest_one(angle: float) -> None:
    (measured,), (velocity,) = encoders("quantisation").measure(np.array([angle]), np.array([0.5]))
    step = NUMBERS.encoder_resolution
    assert abs(measured - angle) <= step / 2 * (1 + 1e-9)
    assert measured / step == pytest.approx(round(measured / step), abs=1e-6)
    assert velocity == 0.5


def test_noise_is_white_and_of_the_given_standard_deviation() -> None:
    sensor = encoders("noise")
    truth = np.array([0.3, -0.7, 1.1, 0.0])
    noise = np.array([sensor.measure(truth, truth)[0] for _ in range(20_000)]) - truth
    scaled = noise / NUMBERS.encoder_noise
    # five standard deviations of each estimate from 20 000 samples
    bound = 5 / math.sqrt(len(noise))
    np.testing.assert_allclose(scaled.mean(axis=0), 0, atol=bound)
    np.testing.assert_allclose((scaled**2).mean(axis=0), 1, atol=bound * math.sqrt(2))
    np.testing.assert_allclose((scaled[1:] * scaled[:-1]).mean(axis=0), 0, atol=bound)
    np.testing.assert_allclose((scaled[:, 0] * scaled[:, 1]).mean(), 0, atol=bound)


def test_noise_depends_on_the_seed_only() -> None:
    truth = np.zeros(5)
    one, again, other = (
        encoders("noise", seed=seed).measure(truth, truth)[0] for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one, again)
    assert (one != other).all()


def test_a_ramp_is_differenced_exactly_from_the_start() -> None:
    sensor, velocity = encoders("differencing"), np.array([0.7, -2.0])
    for tick in range(50):
        angles, measured = sensor.measure(velocity * tick * DT, velocity)
        np.testing.assert_array_equal(angles, velocity * tick * DT)
        np.testing.assert_allclose(measured, velocity, rtol=1e-9)


def test_velocities_step_as_a_first_order_low_pass_does() -> None:
    # at rest until now, then 1 rad/s: 1 - exp(-t / T)
    sensor = encoders("differencing")
    sensor.measure(np.zeros(1), np.zeros(1))
    for tick in range(1, 60):
        _, measured = sensor.measure(np.array([tick * DT]), np.ones(1))
        expected = 1 - math.exp(-tick * DT / NUMBERS.velocity_filter)
        assert measured[0] == pytest.approx(expected, abs=1e-9)


def test_velocities_of_an_acceleration_lag_behind_by_a_constant() -> None:
    # differencing tells the velocity half a step ago, the filter that of
    # dt / (exp(dt / T) - 1) ago, about T
    sensor, acceleration = encoders("differencing"), 3.0
    for tick in range(200):
        time = tick * DT
        _, measured = sensor.measure(
            np.array([acceleration / 2 * time**2]), np.array([acceleration * time])
        )
    behind = DT / 2 + DT / math.expm1(DT / NUMBERS.velocity_filter)
    assert measured[0] == pytest.approx(acceleration * (time - behind), abs=1e-9)
    assert behind == pytest.approx(NUMBERS.velocity_filter, rel=0.01)


def test_without_a_filter_velocities_are_bare_differences() -> None:
    numbers = NUMBERS.model_copy(update={"velocity_filter": 0.0})
    sensor = Encoders(numbers, ["differencing", "quantisation"], DT, np.random.default_rng(0))
    sensor.measure(np.zeros(1), np.zeros(1))
    _, measured = sensor.measure(np.array([2.6e-4]), np.zeros(1))
    assert measured[0] == pytest.approx(3e-4 / DT, rel=1e-12)


# base from flat feet


def on_still_feet(robot: Robot, rng: np.random.Generator) -> State:
    """A random posture and motion with the feet at rest where they are at home."""
    model, data = robot.model, robot.model.createData()
    places = robot.sole_placements(robot.home.q)

    def jacobian(q: np.ndarray) -> np.ndarray:
        return feet_jacobian(robot.feet, model, data, q)

    free = null_space(jacobian(robot.home.q), rcond=1e-6)
    step = free @ rng.uniform(-0.15, 0.15, free.shape[1])
    q = pinocchio.integrate(model, robot.home.q, step)
    for _ in range(10):
        J = jacobian(q)
        feet = zip(robot.feet, places, strict=True)
        error = np.concatenate([foot.error(data, place) for foot, place in feet])
        q = pinocchio.integrate(model, q, np.linalg.lstsq(J, error, rcond=None)[0])
    assert np.abs(error).max() < 1e-12
    free = null_space(jacobian(q), rcond=1e-6)
    return State(q, free @ rng.uniform(-1.0, 1.0, free.shape[1]))


@pytest.mark.parametrize("name", ["robot", "mini_biped", "mini_quadruped"])
def test_base_is_recovered_exactly_while_the_feet_are_still(
    name: str, request: pytest.FixtureRequest
) -> None:
    any_robot: Robot = request.getfixturevalue(name)
    estimator = make_base_estimator(any_robot, any_robot.home)
    rng = np.random.default_rng(5)
    for _ in range(20):
        state = on_still_feet(any_robot, rng)
        estimate = estimator.estimate(state.q[7:], state.v[6:])
        np.testing.assert_allclose(
            pinocchio.difference(any_robot.model, state.q, estimate.q), 0, atol=1e-9
        )
        np.testing.assert_allclose(estimate.v, state.v, atol=1e-9)
        # really something to recover
        assert np.abs(state.v[:6]).max() > 1e-2
        assert np.abs(state.q[:6] - any_robot.home.q[:6]).max() > 1e-3


def test_feet_that_disagree_are_met_half_way(robot: Robot) -> None:
    rng = np.random.default_rng(6)
    state = on_still_feet(robot, rng)
    angles = state.q[7:] + rng.normal(scale=0.01, size=robot.n)
    estimate = FlatFeetEstimator(robot, robot.home).estimate(angles, state.v[6:])
    bases = []
    for now, then in zip(
        robot.sole_placements(estimate.q), robot.sole_placements(robot.home.q), strict=True
    ):
        base = pinocchio.XYZQUATToSE3(estimate.q[:7])
        bases.append(then * now.inverse() * base)
    one, other = (pinocchio.log6(base.actInv(seen)).vector for seen in bases)
    np.testing.assert_allclose(one, -other, atol=1e-9)
    assert np.abs(one).max() > 1e-3


def test_base_velocity_moves_the_soles_least(robot: Robot) -> None:
    rng = np.random.default_rng(7)
    state = on_still_feet(robot, rng)
    velocities = rng.normal(size=robot.n)
    estimate = FlatFeetEstimator(robot, robot.home).estimate(state.q[7:], velocities)
    data = robot.model.createData()
    J = np.vstack(
        [
            pinocchio.computeFrameJacobian(robot.model, data, state.q, frame, pinocchio.LOCAL)
            for frame in robot.sole_frames
        ]
    )
    expected = np.linalg.lstsq(J[:, :6], -J[:, 6:] @ velocities, rcond=None)[0]
    np.testing.assert_allclose(estimate.v[:6], expected, atol=1e-9)
    np.testing.assert_array_equal(estimate.v[6:], velocities)


def test_points_that_disagree_are_fitted_by_least_squares(mini_quadruped: Robot) -> None:
    rng = np.random.default_rng(8)
    angles = mini_quadruped.home.q[7:] + rng.normal(scale=0.01, size=mini_quadruped.n)
    velocities = rng.normal(size=mini_quadruped.n)
    estimator = StillPointsEstimator(mini_quadruped, mini_quadruped.home)
    estimate = estimator.estimate(angles, velocities)
    places = mini_quadruped.sole_placements(mini_quadruped.home.q)
    model, data = mini_quadruped.model, mini_quadruped.model.createData()
    J = feet_jacobian(mini_quadruped.feet, model, data, estimate.q)
    feet = zip(mini_quadruped.feet, places, strict=True)
    error = np.concatenate([foot.error(data, place) for foot, place in feet])
    assert np.abs(error).max() > 1e-3
    # no way of moving the base makes it smaller, to first order
    np.testing.assert_allclose(J[:, :6].T @ error, 0, atol=1e-9)
    # and of the velocities either: the base's that leaves the points least
    np.testing.assert_allclose(J[:, :6].T @ (J @ estimate.v), 0, atol=1e-9)


def test_the_base_is_not_estimated_from_feet_of_two_kinds(peg_leg: Robot) -> None:
    described = peg_leg.description.model_copy(update={"hardware": NUMBERS})
    both = copy.copy(peg_leg)
    both.description = described
    assert "flat_feet" not in check_effects(both, ["friction", "noise"])
    for effects in (["flat_feet"], ["all"]):
        with pytest.raises(InvalidValue, match="peg_leg stands on both"):
            check_effects(both, effects)


def test_soles_are_where_the_robot_was_put_and_not_at_home(robot: Robot) -> None:
    # carried 2 m away and turned: the joints cannot tell, the estimator has to be told
    q = robot.home.q.copy()
    q[:2] = 2.0, -1.0
    q[3:7] = 0, 0, math.sin(0.4), math.cos(0.4)
    estimate = FlatFeetEstimator(robot, State(q, robot.home.v)).estimate(q[7:], np.zeros(robot.n))
    np.testing.assert_allclose(pinocchio.difference(robot.model, q, estimate.q), 0, atol=1e-9)


# friction and armature in MuJoCo

WHEEL = """
<mujoco><option timestep="0.001" integrator="Euler" gravity="0 0 0"/>
  <worldbody><body><joint name="axle" axis="0 0 1"/>
    <inertial pos="0 0 0" mass="1" diaginertia="0.15 0.15 0.15"/></body></worldbody>
  <actuator><motor joint="axle"/></actuator></mujoco>
"""
INERTIA = 0.15  # kg m^2


def spin(effects: list[str], seconds: float, speed: float = 0.0, torque: float = 0.0) -> float:
    """Speed of a wheel after some time [rad/s]."""
    model = mujoco.MjModel.from_xml_string(WHEEL)
    add_to_model(model, np.array([0]), NUMBERS, effects)
    mujoco.mj_setConst(model, mujoco.MjData(model))
    data = mujoco.MjData(model)
    data.qvel[0], data.ctrl[0] = speed, torque
    for _ in range(round(seconds / DT)):
        mujoco.mj_step(model, data)
    return float(data.qvel[0])


def test_armature_adds_to_the_inertia() -> None:
    assert spin([], 1.0, torque=0.3) == pytest.approx(0.3 / INERTIA, rel=1e-9)
    loaded = 0.3 / (INERTIA + NUMBERS.armature)
    assert spin(["armature"], 1.0, torque=0.3) == pytest.approx(loaded, rel=1e-9)


@pytest.mark.parametrize("effects", [["friction"], ["friction", "armature"]])
def test_friction_slows_a_wheel_as_it_should(effects: list[str]) -> None:
    # J dw/dt = -(b w + c)
    b, c = NUMBERS.viscous_friction, NUMBERS.coulomb_friction
    J = INERTIA + (NUMBERS.armature if "armature" in effects else 0.0)
    speed, seconds = 30.0, 0.3
    expected = (speed + c / b) * math.exp(-b * seconds / J) - c / b
    assert 0 < expected < 0.5 * speed
    assert spin(effects, seconds, speed) == pytest.approx(expected, rel=0.01)


def test_coulomb_friction_holds_against_a_smaller_torque() -> None:
    c = NUMBERS.coulomb_friction
    assert abs(spin(["friction"], 0.5, torque=0.9 * c)) < 0.02
    assert spin(["friction"], 0.5, torque=1.5 * c) > 0.5
    assert abs(spin(["friction"], 2.0, speed=3.0)) < 1e-3


def test_other_effects_leave_the_model_alone() -> None:
    others = [effect for effect in EFFECTS if effect not in ("armature", "friction")]
    assert spin(others, 0.5, speed=3.0) == pytest.approx(3.0, rel=1e-12)


def test_the_simulated_robots_joints_get_them_and_its_base_does_not(robot: Robot) -> None:
    hardware = robot.description.hardware
    assert hardware is not None
    simulator = MujocoSimulator(robot, hardware=["all"])
    joints, model = simulator.state_map.v_joints, simulator.model
    for values, expected in (
        (model.dof_armature, hardware.armature),
        (model.dof_damping, hardware.viscous_friction),
        (model.dof_frictionloss, hardware.coulomb_friction),
    ):
        np.testing.assert_array_equal(values[joints], expected)
        np.testing.assert_array_equal(np.delete(values, joints), 0.0)
    for values in (MujocoSimulator(robot).model.dof_damping, robot.model.armature[6:]):
        assert not values.any()
