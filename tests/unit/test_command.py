from __future__ import annotations

import numpy as np
import pytest

from tsd_casadi import Command, InverseDynamics, Robot, State
from tsd_casadi.exceptions import InvalidValue, UnknownField


@pytest.fixture
def command(problem: InverseDynamics) -> Command:
    return Command(problem.request)


def test_starts_from_the_defaults(command: Command, problem: InverseDynamics) -> None:
    np.testing.assert_array_equal(command.request, problem.request.defaults())


def test_defaults_hold_home(command: Command, robot: Robot) -> None:
    np.testing.assert_array_equal(command["q"], robot.home.q)
    np.testing.assert_allclose(command["com.reference"], robot.home_com)
    np.testing.assert_array_equal(command["posture.q_ref"], robot.home.q[7:])
    np.testing.assert_array_equal(command["limits.torque"], robot.torque_limit)
    share = robot.weight / 2
    for contact in robot.description.contacts:
        wanted = command[f"{contact.name}.lambda_des"]
        np.testing.assert_allclose(wanted, [0, 0, share, 0, 0, 0])
        np.testing.assert_array_equal(command[f"{contact.name}.extents"], [*contact.x, *contact.y])


def test_a_field_is_a_writable_view(command: Command, problem: InverseDynamics) -> None:
    command["com.reference"][2] += 0.25
    place = problem.request.slice("com.reference").start + 2
    assert command.request[place] == problem.request.defaults()[place] + 0.25


def test_one_number_fills_a_field(command: Command) -> None:
    command["com.P"] = 7
    np.testing.assert_array_equal(command["com.P"], [7, 7, 7])
    command["com.P"] = [3.0]
    np.testing.assert_array_equal(command["com.P"], [3, 3, 3])


def test_a_vector_sets_a_field_and_nothing_else(command: Command) -> None:
    before = command.request.copy()
    command["com.P"] = [1, 2, 3]
    changed = np.flatnonzero(command.request != before)
    np.testing.assert_array_equal(command.request[changed], [1, 2, 3])


@pytest.mark.parametrize("value", [[1.0, 2.0], np.ones((1, 3)), np.ones(4), []])
def test_another_shape_is_refused(value: object, command: Command) -> None:
    before = command.request.copy()
    with pytest.raises(InvalidValue, match=r"com\.P is of shape .*\(3,\)"):
        command["com.P"] = value  # type: ignore[assignment]
    np.testing.assert_array_equal(command.request, before)


def test_unknown_field_is_named(command: Command) -> None:
    with pytest.raises(UnknownField, match=r"com\.p"):
        command["com.p"] = 1.0
    with pytest.raises(UnknownField, match=r"com\.P"):
        command["com.p"]


def test_a_copy_is_independent(command: Command) -> None:
    command["com.P"] = 9.0
    other = command.copy()
    other["com.D"] = 1.0
    np.testing.assert_array_equal(other["com.P"], command["com.P"])
    assert command["com.D"][0] != 1.0


def test_two_commands_do_not_share_their_defaults(problem: InverseDynamics) -> None:
    Command(problem.request)["com.P"] = 0.0
    assert Command(problem.request)["com.P"][0] > 0


def test_set_state_writes_q_and_v(command: Command, robot: Robot) -> None:
    rng = np.random.default_rng(0)
    before = command.request.copy()
    state = State(rng.normal(size=robot.nq), rng.normal(size=robot.nv))
    command.set_state(state)
    np.testing.assert_array_equal(command["q"], state.q)
    np.testing.assert_array_equal(command["v"], state.v)
    size = robot.nq + robot.nv
    np.testing.assert_array_equal(command.request[size:], before[size:])
