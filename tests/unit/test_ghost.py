from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi import Controller, Robot, load_robot
from tsd_casadi.motions.hold import hold
from tsd_casadi.robot.ghost import error_axes, ghost_posture
from tsd_casadi.state import State, Vector


def _off(robot: Robot, seed: int, size: float) -> Vector:
    """A posture with every joint off home, as a robot with a wrong model has it."""
    q = robot.home.q.copy()
    q[7:] += np.random.default_rng(seed).uniform(-size, size, robot.n)
    return robot.put_on_ground(q)


def _errors(controller: Controller, robot: Robot, q: Vector) -> dict[str, float]:
    """Errors against home as the compiled controller computes them, by axis."""
    command = controller.command()
    hold(command, robot, robot.home)
    error = controller.tick(State(q, np.zeros(robot.nv)), command).error
    return dict(zip(error_axes(robot), error, strict=True))


def test_axes_are_in_the_order_of_a_ticks_errors(
    any_robot: Robot, any_controller: Controller
) -> None:
    known = any_controller.format.axes
    assert error_axes(any_robot) == tuple(f"{task}.{axis}" for task, axis in known)


def test_the_controller_sees_no_error_in_the_ghost(
    any_robot: Robot, any_controller: Controller
) -> None:
    q = _off(any_robot, seed=1, size=0.02)
    errors = _errors(any_controller, any_robot, q)
    active = {
        part.name for part in any_robot.description.tasks if part.type == "com" or part.active
    }
    counted = [axis for axis in errors if axis.split(".")[0] in active]
    assert max(abs(errors[axis]) for axis in counted) > 1e-4
    ghost = ghost_posture(any_robot, q, errors)
    left = _errors(any_controller, any_robot, ghost)
    assert max(abs(left[axis]) for axis in counted) < 1e-6


@given(st.integers(0, 10**6), st.floats(0.0, 0.04))
def test_feet_stay_and_the_centre_of_mass_goes_by_its_error(
    robot: Robot, seed: int, size: float
) -> None:
    q = _off(robot, seed, size)
    wanted = np.random.default_rng(seed).uniform(-size, size, 3)
    errors = {f"com.{axis}": value for axis, value in zip("xyz", wanted, strict=True)}
    ghost = ghost_posture(robot, q, errors)
    assert robot.center_of_mass(ghost) - robot.center_of_mass(q) == pytest.approx(wanted, abs=1e-6)
    for was, now in zip(robot.sole_placements(q), robot.sole_placements(ghost), strict=True):
        assert pinocchio.log6(was.actInv(now)).vector == pytest.approx(np.zeros(6), abs=1e-6)


def test_without_errors_the_ghost_is_the_robot(any_robot: Robot) -> None:
    q = _off(any_robot, seed=2, size=0.02)
    assert np.array_equal(ghost_posture(any_robot, q, {}), q)


def test_an_inactive_task_counts_where_it_moves() -> None:
    robot = load_robot("g1")
    q = robot.home.q
    moved = {"left_hand.z": 0.03}
    assert np.array_equal(ghost_posture(robot, q, moved), q)
    ghost = ghost_posture(robot, q, moved, moved)
    frame = robot.frame_name("left_hand")
    rise = robot.frame_placement(frame, ghost)[0] - robot.frame_placement(frame, q)[0]
    assert rise == pytest.approx([0.0, 0.0, 0.03], abs=1e-6)


def test_out_of_reach_the_ghost_is_finite_and_bounded(robot: Robot) -> None:
    ghost = ghost_posture(robot, robot.home.q, {"com.z": 2.0})
    assert np.isfinite(ghost).all()
    assert np.linalg.norm(ghost[3:7]) == pytest.approx(1.0)
