"""A joint that is past a limit is named also where it comes back faster than it has to."""

from __future__ import annotations

import numpy as np
import pytest

from tsd_casadi import Controller, Robot
from tsd_casadi.state import State

JOINT = "B_TR"
LIMIT = 1.0
RETURN = 0.5  # rad/s


@pytest.fixture(scope="module")
def place(robot: Robot) -> int:
    return robot.joint_names.index(JOINT)


def active(
    controller: Controller, robot: Robot, place: int, q: float, v: float, on: float
) -> dict[str, float]:
    """What is said of the joint, bounded by 0 +- LIMIT rad and rad/s."""
    command = controller.command()
    command["limits.position_lower"][place], command["limits.position_upper"][place] = -LIMIT, LIMIT
    command["limits.velocity"][place] = LIMIT
    command["limits.position_active"] = command["limits.velocity_active"] = on
    state = State(robot.home.q.copy(), np.zeros(robot.nv))
    state.q[7 + place], state.v[6 + place] = q, v
    # back to the middle, at once
    command["posture.q_ref"][place] = -10 * (q or v)
    tick = controller.tick(state, command)
    row = controller.format.row_names.index(f"joint_acceleration.{JOINT}")
    said = float(tick.reply[controller.format.reply.slice("active")][row])
    return {name: said for name in tick.active if name.endswith(f".{JOINT}")}


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("beyond", [-1e-6, 1e-6])
def test_faster_than_its_limit_and_braking(
    robot: Robot, controller: Controller, place: int, side: int, beyond: float
) -> None:
    said = active(controller, robot, place, 0.0, side * (LIMIT + beyond), 1.0)
    assert said == ({f"joint_velocity.{JOINT}": 8.0 * side} if beyond > 0 else {})


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("beyond", [-1e-6, 1e-6])
def test_beyond_its_stop_and_coming_back(
    robot: Robot, controller: Controller, place: int, side: int, beyond: float
) -> None:
    said = active(controller, robot, place, side * (LIMIT + beyond), -side * RETURN, 1.0)
    assert said == ({f"joint_position.{JOINT}": 7.0 * side} if beyond > 0 else {})


def test_limits_that_are_switched_off_are_not_passed(
    robot: Robot, controller: Controller, place: int
) -> None:
    assert active(controller, robot, place, 1.1 * LIMIT, 1.1 * LIMIT, 0.0) == {}
