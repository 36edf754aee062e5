"""What holds a robot while no torque is answered."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pinocchio
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi import InverseDynamics, Robot, State, load_robot
from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.fallback.contact_jacobian import contact_jacobian
from tsd_casadi.fallback.decaying_torque import DecayingTorque
from tsd_casadi.fallback.fallback import fallback_of
from tsd_casadi.fallback.gravity_torque import GravityTorque
from tsd_casadi.fallback.held_posture import HeldPosture
from tsd_casadi.fallback.hold_gains import (
    DAMPING_RATIO,
    DAMPING_TIME,
    FREQUENCY,
    SLIDING_STIFFNESS,
    STIFFNESS,
    hold_gains,
    standing_inertia,
)
from tsd_casadi.fallback.no_torque import NoTorque

PERIOD = 1e-3


def test_gravity_torque_is_the_compiled_safe_torque_at_rest(any_robot: Robot) -> None:
    problem = InverseDynamics(any_robot)
    request = problem.format.request.defaults()
    rng = np.random.default_rng(0)
    gravity = GravityTorque(any_robot)
    for _ in range(3):
        q = any_robot.home.q.copy()
        q[7:] += 0.1 * rng.normal(size=any_robot.n)
        request[problem.format.request.slice("q")] = q
        safe = np.array(problem.safe_torque(ca.DM(request))).ravel()
        limit = any_robot.torque_limit
        np.testing.assert_allclose(np.clip(gravity(q), -limit, limit), safe, rtol=0, atol=1e-6)


def test_hold_pulls_joints_back_to_where_they_were_latched_and_brakes(robot: Robot) -> None:
    hold = HeldPosture(robot, P=100.0, D=3.0)
    hold.latch(robot.home)
    q, v = robot.home.q.copy(), np.zeros(robot.nv)
    q[7:] += 0.01
    v[6:] = 0.2
    expected = GravityTorque(robot)(q) - 1.0 - 0.6
    np.testing.assert_allclose(hold.torque(State(q, v)), expected, rtol=0, atol=1e-12)
    hold.latch(State(q, v))
    np.testing.assert_allclose(hold.torque(State(q, v)), expected + 1.0, rtol=0, atol=1e-12)


@given(joints=st.floats(-3.0, 3.0), speed=st.floats(-50.0, 50.0))
def test_hold_keeps_the_limits(robot: Robot, joints: float, speed: float) -> None:
    hold = HeldPosture(robot)
    hold.latch(robot.home)
    q, v = robot.home.q.copy(), np.full(robot.nv, speed)
    q[7:] += joints
    assert (np.abs(hold.torque(State(q, v))) <= robot.torque_limit).all()


def test_gains_of_what_carries_the_robot_go_with_weight_and_height(
    robot: Robot, mini_biped: Robot
) -> None:
    P, D = hold_gains(robot)
    knee = robot.joint_names.index("L_KFE")
    assert P[knee] == pytest.approx(STIFFNESS * robot.weight * robot.home_com[2])
    assert D[knee] == pytest.approx(DAMPING_TIME * np.sqrt(robot.home_com[2] / 9.81) * P[knee])
    # its legs slide: N/m, not N m/rad
    slide = mini_biped.joint_names.index("far_slide")
    stiffness = HeldPosture(mini_biped).P[slide]
    expected = SLIDING_STIFFNESS * mini_biped.weight / mini_biped.home_com[2]
    assert stiffness == pytest.approx(expected)


def test_gains_of_what_carries_nothing_go_with_its_inertia(any_robot: Robot) -> None:
    P, D = hold_gains(any_robot)
    inertia = standing_inertia(any_robot)
    tipping = any_robot.weight * any_robot.home_com[2]
    light = np.flatnonzero(0.9 * STIFFNESS * tipping > P)
    assert light.size
    np.testing.assert_allclose(P[light], FREQUENCY**2 * inertia[light])
    assert (2 * DAMPING_RATIO * FREQUENCY * inertia * (1 + 1e-9) >= D).all()
    # explicit integration of the longest control period stands it
    assert (D[light] * 5e-3 / inertia[light]).max() < 1.0


def test_standing_inertia_is_what_the_forward_dynamics_with_contacts_answers(
    robot: Robot,
) -> None:
    model, data = robot.model, robot.model.createData()
    q = robot.home.q
    J = contact_jacobian(robot, data, q)
    bias = pinocchio.nonLinearEffects(model, data, q, np.zeros(robot.nv))
    expected = np.empty(robot.n)
    for joint in range(robot.n):
        tau = bias.copy()
        tau[6 + joint] += 1.0
        drift = np.zeros(len(J))
        # Pinocchio's own solution of the constrained dynamics
        a = pinocchio.forwardDynamics(model, data, q, np.zeros(robot.nv), tau, J, drift, 1e-12)
        expected[joint] = 1 / a[6 + joint]
    np.testing.assert_allclose(standing_inertia(robot), expected, rtol=1e-3)


def test_decaying_torque_falls_by_its_time(robot: Robot) -> None:
    decay = DecayingTorque(2, time=0.1, period=PERIOD)
    decay.watch(np.array([10.0, -4.0]))
    decay.latch(robot.home)
    for _ in range(100):
        tau = decay.torque(robot.home)
    np.testing.assert_allclose(tau, np.array([10.0, -4.0]) / np.e)


def test_decaying_torque_before_any_answer_is_none(robot: Robot) -> None:
    decay = DecayingTorque(2, time=0.1, period=PERIOD)
    decay.latch(robot.home)
    np.testing.assert_array_equal(decay.torque(robot.home), 0.0)


@pytest.mark.parametrize(
    ("section", "kind"),
    [
        (None, HeldPosture),
        ({}, HeldPosture),
        ({"P": 300.0, "D": 20.0}, HeldPosture),
        ({"kind": "hold", "P": 300.0}, HeldPosture),
        ({"kind": "decay", "time": 0.2}, DecayingTorque),
        ({"kind": "zero"}, NoTorque),
    ],
)
def test_robot_file_says_which(
    write_robot: Callable[..., Path], section: dict[str, Any] | None, kind: type
) -> None:
    def edit(document: dict[str, Any]) -> None:
        if section is not None:
            document["fallback"] = section

    fallback = fallback_of(load_robot(write_robot(edit)), PERIOD)
    assert type(fallback) is kind
    if isinstance(fallback, HeldPosture) and section and "P" in section:
        np.testing.assert_array_equal(fallback.P, section["P"])


@pytest.mark.parametrize(
    ("section", "field"),
    [
        ({"kind": "wave"}, "fallback.kind"),
        ({"kind": "decay"}, "fallback.time"),
        ({"kind": "decay", "time": 0.0}, "fallback.time"),
        ({"kind": "zero", "P": 1.0}, "fallback.P"),
        ({"P": -1.0}, "fallback.P"),
        ({"kind": "hold", "time": 1.0}, "fallback.time"),
    ],
)
def test_what_is_no_fallback_is_refused_by_its_field(
    write_robot: Callable[..., Path], section: dict[str, Any], field: str
) -> None:
    path = write_robot(lambda document: document.update(fallback=section))
    with pytest.raises(RobotFileError) as refused:
        load_robot(path)
    assert refused.value.field == field
