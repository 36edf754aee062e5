from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pinocchio
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi.repetition.rotation import SMALL, angular_motion, multiply, quaternion_of
from tsd_casadi.state import Vector

STEP = 1e-4
numbers = st.floats(-1.0, 1.0)
rates = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(np.array)
# nothing at all, near nothing, about where the series end, anything, near half a turn
lengths = st.one_of(
    st.just(0.0),
    st.floats(1e-9, 1e-3),
    st.floats(0.5 * SMALL, 2 * SMALL),
    st.floats(0.01, 3.0),
    st.floats(math.pi - 1e-6, math.pi + 1e-6),
)


@st.composite
def rotation_vectors(draw: st.DrawFn) -> Vector:
    direction = np.array(draw(st.tuples(numbers, numbers, numbers)))
    size = float(np.linalg.norm(direction))
    direction = np.array([0.0, 0.0, 1.0]) if size < 1e-3 else direction / size
    return draw(lengths) * direction


def path(theta: Vector, rate: Vector, rate_rate: Vector) -> Callable[[float], Vector]:
    """A rotation vector with these derivatives at time 0."""
    return lambda time: theta + time * rate + time**2 / 2 * rate_rate


def omega_by_differences(at: Callable[[float], Vector], time: float) -> Vector:
    """Angular velocity in world axes, from rotation matrices."""
    before, after = (pinocchio.exp3(at(time + step)) for step in (-STEP, STEP))
    return np.array(pinocchio.log3(after @ before.T)) / (2 * STEP)


@given(rotation_vectors())
def test_quaternions_are_those_of_rotation_vectors(theta: Vector) -> None:
    quaternion = quaternion_of(theta)
    assert np.linalg.norm(quaternion) == pytest.approx(1, abs=1e-14)
    matrix = pinocchio.Quaternion(quaternion).matrix()
    np.testing.assert_allclose(matrix, pinocchio.exp3(theta), atol=1e-12)


@given(rotation_vectors(), rotation_vectors())
def test_products_turn_by_the_other_first(one: Vector, other: Vector) -> None:
    product = pinocchio.Quaternion(multiply(quaternion_of(one), quaternion_of(other))).matrix()
    np.testing.assert_allclose(product, pinocchio.exp3(one) @ pinocchio.exp3(other), atol=1e-12)


@given(rotation_vectors(), rates, rates)
def test_angular_velocity_and_acceleration_are_those_of_the_rotation(
    theta: Vector, rate: Vector, rate_rate: Vector
) -> None:
    at = path(theta, rate, rate_rate)
    omega, alpha = angular_motion(theta, rate, rate_rate)
    np.testing.assert_allclose(omega, omega_by_differences(at, 0.0), atol=1e-5)

    def omega_at(time: float) -> Vector:
        return angular_motion(at(time), rate + time * rate_rate, rate_rate)[0]

    by_differences = (omega_at(STEP) - omega_at(-STEP)) / (2 * STEP)
    np.testing.assert_allclose(alpha, by_differences, atol=1e-5)


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.6, 0.0, -0.8), (0.36, 0.48, 0.8)])
def test_the_series_meet_what_they_stand_for(direction: tuple[float, ...]) -> None:
    rate, rate_rate = np.array([0.3, -2.0, 1.0]), np.array([1.0, 0.5, -4.0])
    below, above = (
        angular_motion(share * SMALL * np.array(direction), rate, rate_rate)
        for share in (1 - 1e-9, 1 + 1e-9)
    )
    np.testing.assert_allclose(below, above, atol=1e-9)


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_about_one_axis_there_is_nothing_to_compute(x: float, xd: float, xdd: float) -> None:
    axis = np.array([0.0, 0.6, 0.8])
    omega, alpha = angular_motion(x * axis, xd * axis, xdd * axis)
    np.testing.assert_allclose(omega, xd * axis, atol=1e-12)
    np.testing.assert_allclose(alpha, xdd * axis, atol=1e-12)
