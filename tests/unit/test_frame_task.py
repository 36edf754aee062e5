from __future__ import annotations

import casadi as ca
import numpy as np
import pinocchio
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tsd_casadi import Robot
from tsd_casadi.dynamics.rotation import rotation_matrix, rotation_vector
from tsd_casadi.dynamics.symbolic_dynamics import SymbolicDynamics
from tsd_casadi.robot.robot_file_sections import FRAME_AXES
from tsd_casadi.tasks.frame_task import FrameTask
from tsd_casadi.tasks.symmetric import pack_lower_triangle, symmetric_matrix
from tsd_clients.simulator.parity import random_state

FRAME = "R_sole"
STEP = 1e-6
SUBSETS = (FRAME_AXES, ("rx", "ry", "rz"), ("z", "ry"), ("rz", "x"))

_R, _quaternion = ca.SX.sym("R", 3, 3), ca.SX.sym("quaternion", 4)
LOGARITHM = ca.Function("logarithm", [_R], [rotation_vector(_R)])
MATRIX = ca.Function("matrix", [_quaternion], [rotation_matrix(_quaternion)])

components = st.floats(-1, 1)
directions = (
    st.tuples(components, components, components)
    .filter(lambda x: np.linalg.norm(x) > 1e-3)
    .map(lambda x: np.array(x) / np.linalg.norm(x))
)


def log_of(rotation: Rotation) -> np.ndarray:
    return np.array(LOGARITHM(rotation.as_matrix()))[:, 0]


@given(axis=directions, angle=st.floats(0, np.pi - 1e-3))
def test_rotation_vector(axis: np.ndarray, angle: float) -> None:
    np.testing.assert_allclose(
        log_of(Rotation.from_rotvec(angle * axis)), angle * axis, atol=1e-11, rtol=0
    )


@given(axis=directions, exponent=st.floats(-12, -1))
def test_rotation_vector_near_zero(axis: np.ndarray, exponent: float) -> None:
    angle = 10**exponent
    np.testing.assert_allclose(
        log_of(Rotation.from_rotvec(angle * axis)), angle * axis, atol=3e-16, rtol=1e-11
    )


@given(axis=directions, exponent=st.floats(-5, -3))
def test_rotation_vector_near_pi_loses_digits_but_not_its_direction(
    axis: np.ndarray, exponent: float
) -> None:
    angle = np.pi - 10**exponent
    np.testing.assert_allclose(
        log_of(Rotation.from_rotvec(angle * axis)),
        angle * axis,
        atol=1e-14 * 10**-exponent,
        rtol=0,
    )


@pytest.mark.parametrize("short_of_pi", [0.0, 1e-9, 1e-7])
@pytest.mark.parametrize("axis", np.eye(3).tolist(), ids="xyz")
def test_half_a_turn_is_not_no_turn(axis: list[float], short_of_pi: float) -> None:
    angle = np.pi - short_of_pi
    found = log_of(Rotation.from_rotvec(angle * np.array(axis)))
    assert np.linalg.norm(found) == pytest.approx(np.pi, abs=1e-5)


def test_rotation_vector_of_no_turn_is_zero() -> None:
    assert not log_of(Rotation.identity()).any()


@given(axis=directions, angle=st.floats(-np.pi, np.pi), scale=st.floats(0.5, 2.0))
def test_rotation_matrix_normalises(axis: np.ndarray, angle: float, scale: float) -> None:
    rotation = Rotation.from_rotvec(angle * axis)
    found = np.array(MATRIX(scale * rotation.as_quat()))
    np.testing.assert_allclose(found, rotation.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-14)


def terms_function(robot: Robot, axes: tuple[str, ...]) -> ca.Function:
    q, v = ca.SX.sym("q", robot.nq), ca.SX.sym("v", robot.nv)
    task = FrameTask("task", FRAME, axes, 1.0, 2.0, 3.0)
    command = {
        "reference": ca.SX.sym("reference", 7),
        "reference_velocity": ca.SX.sym("reference_velocity", task.k),
    }
    terms = task.terms(SymbolicDynamics(robot, q, v), lambda name: command[name])
    outputs = [terms.J, terms.drift, terms.error, terms.error_rate]
    return ca.Function("terms", [q, v, *command.values()], outputs)


def placement(robot: Robot, q: np.ndarray) -> tuple[np.ndarray, Rotation]:
    data = robot.model.createData()
    pinocchio.framesForwardKinematics(robot.model, data, q)
    frame = data.oMf[robot.model.getFrameId(FRAME)]
    return np.array(frame.translation), Rotation.from_matrix(frame.rotation)


def velocity(robot: Robot, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    ahead, behind = (
        placement(robot, pinocchio.integrate(robot.model, q, sign * STEP * v)) for sign in (1, -1)
    )
    turned = (ahead[1] * behind[1].inv()).as_rotvec()
    return np.concatenate((ahead[0] - behind[0], turned)) / (2 * STEP)


@pytest.mark.parametrize("axes", SUBSETS, ids="".join)
def test_error_and_rates_against_numeric_kinematics(robot: Robot, axes: tuple[str, ...]) -> None:
    terms = terms_function(robot, axes)
    rows = [FRAME_AXES.index(axis) for axis in axes]
    rng = np.random.default_rng(0)
    for _ in range(5):
        state = random_state(robot, rng)
        position, rotation = placement(robot, state.q)
        away = Rotation.from_rotvec(rng.uniform(-1, 1, 3))
        reference = np.concatenate((position + rng.normal(size=3), (away * rotation).as_quat()))
        expected = np.concatenate((reference[:3] - position, away.as_rotvec()))
        reference_velocity = rng.normal(size=len(axes))
        J, drift, error, error_rate = (
            np.array(part) for part in terms(state.q, state.v, reference, reference_velocity)
        )
        moving = velocity(robot, state.q, state.v)[rows]
        np.testing.assert_allclose(error[:, 0], expected[rows], atol=1e-10)
        np.testing.assert_allclose(J @ state.v, moving, atol=1e-6)
        np.testing.assert_allclose(error_rate[:, 0], reference_velocity - moving, atol=1e-6)
        ahead, behind = (
            np.array(
                terms(
                    pinocchio.integrate(robot.model, state.q, sign * STEP * state.v),
                    state.v,
                    reference,
                    reference_velocity,
                )[0]
            )
            for sign in (1, -1)
        )
        np.testing.assert_allclose(drift[:, 0], (ahead - behind) @ state.v / (2 * STEP), atol=1e-5)


def test_error_shrinks_along_minus_j(robot: Robot) -> None:
    terms = terms_function(robot, FRAME_AXES)
    rng = np.random.default_rng(1)
    for _ in range(5):
        state = random_state(robot, rng)
        position, rotation = placement(robot, state.q)
        reference = np.concatenate((position, rotation.as_quat()))
        ahead, behind = (
            np.array(
                terms(
                    pinocchio.integrate(robot.model, state.q, sign * STEP * state.v),
                    state.v,
                    reference,
                    np.zeros(6),
                )[2]
            )
            for sign in (1, -1)
        )
        J = np.array(terms(state.q, state.v, reference, np.zeros(6))[0])
        np.testing.assert_allclose((ahead - behind)[:, 0] / (2 * STEP), -J @ state.v, atol=1e-6)


def test_reference_defaults_to_home(robot: Robot) -> None:
    field = FrameTask("task", FRAME, ("z",), 1.0, 2.0, 3.0).reference_fields(robot)[0]
    position, rotation = placement(robot, robot.home.q)
    np.testing.assert_allclose(field.default[:3], position, atol=1e-12)
    np.testing.assert_allclose(
        Rotation.from_quat(field.default[3:]).as_matrix(), rotation.as_matrix(), atol=1e-12
    )
    assert (field.size, field.unit_quaternion) == (7, 3)


@pytest.mark.parametrize(
    ("axes", "unit"),
    [(("x", "z"), "m/s"), (("rx",), "rad/s"), (("x", "rx"), "m, rad/s")],
)
def test_units_follow_the_axes(robot: Robot, axes: tuple[str, ...], unit: str) -> None:
    fields = {f.name: f for f in FrameTask("task", FRAME, axes, 1.0, 2.0, 3.0).fields(robot)}
    assert fields["task.reference_velocity"].unit == unit
    assert fields["task.reference_velocity"].size == len(axes)


@given(k=st.integers(1, 6), seed=st.integers(0, 1000))
def test_symmetric_matrix_undoes_pack_lower_triangle(k: int, seed: int) -> None:
    square = np.random.default_rng(seed).normal(size=(k, k))
    symmetric = square + square.T
    packed = pack_lower_triangle(symmetric)
    assert packed.shape == (k * (k + 1) // 2,)
    unpacked = np.array(ca.DM(ca.evalf(symmetric_matrix(ca.SX(ca.DM(packed)), k))))
    np.testing.assert_array_equal(unpacked, symmetric)


def test_lower_triangle_goes_row_by_row() -> None:
    matrix = np.array([[1.0, 2.0, 4.0], [2.0, 3.0, 5.0], [4.0, 5.0, 6.0]])
    np.testing.assert_array_equal(pack_lower_triangle(matrix), [1, 2, 3, 4, 5, 6])
