"""Torque that is left at a speed: bounds, the tick that keeps them, the file that gives them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi import Command, Controller, Robot, Status, Tick, load_robot
from tsd_casadi.constraints.torque_speed import torque_bounds
from tsd_casadi.examination.torque_speed import torque_speed_lines, unreachable_speeds
from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.tick.row_state import RowState

WriteRobot = Callable[..., Path]
LINE = {"stall_torque": 120.0, "no_load_speed": 8.0}

positive = st.floats(0.01, 1e3)


def bounds_at(v: float, limit: float, stall: float, no_load: float) -> tuple[float, float]:
    bounds = torque_bounds(*(ca.SX(value) for value in (v, limit, stall, no_load)))
    return float(ca.evalf(bounds.lower)), float(ca.evalf(bounds.upper))


@given(v=st.floats(-50, 50), limit=positive, stall=positive, no_load=positive)
def test_bounds_drive_less_at_speed_and_brake_as_before(
    v: float, limit: float, stall: float, no_load: float
) -> None:
    lower, upper = bounds_at(v, limit, stall, no_load)
    assert (-upper, -lower) == bounds_at(-v, limit, stall, no_load)
    assert -limit <= lower <= 0 <= upper <= limit  # no torque is ever asked for
    # the power that it takes is what a line has, no more than a quarter of stall times speed
    driving = upper if v > 0 else lower
    assert driving * v <= stall * no_load / 4 * (1 + 1e-12)
    braking = lower if v > 0 else upper
    assert abs(braking) == min(limit, stall * (1 + abs(v) / no_load))
    if abs(v) >= no_load:
        assert driving == 0


def test_where_no_line_is_known_the_torque_limit_counts(robot: Robot) -> None:
    assert bounds_at(9.0, 100.0, 1e9, 1e9) == (-100.0, 100.0)
    assert np.isinf(robot.stall_torque).all()
    assert np.isinf(robot.no_load_speed).all()


@pytest.fixture(scope="module")
def controller(any_controller: Controller) -> Controller:
    return any_controller


@pytest.fixture(scope="module")
def robot_there(any_robot: Robot) -> Robot:
    return any_robot


def moving(robot: Robot, controller: Controller, rng: np.random.Generator) -> Command:
    command = controller.command()
    command["q"], command["v"] = robot.home.q, np.zeros(robot.nv)
    command["v"][6:] = rng.normal(scale=0.5, size=robot.n)
    # little more than what standing needs
    command["limits.stall_torque"] = rng.uniform(0.2, 0.8, robot.n) * robot.torque_limit
    command["limits.no_load_speed"] = rng.uniform(0.3, 3.0, robot.n)
    return command


def test_ticks_keep_what_is_left_and_name_it(robot_there: Robot, controller: Controller) -> None:
    robot, rng = robot_there, np.random.default_rng(0)
    rows = [f"joint_torque.{joint}" for joint in robot.joint_names]
    place = [controller.format.row_names.index(row) for row in rows]
    named, solved = 0, 0
    for _ in range(60):
        command = moving(robot, controller, rng)
        tick = Tick(controller.format, controller.run(command.request))
        share = command["v"][6:] / command["limits.no_load_speed"]
        stall, limit = command["limits.stall_torque"], command["limits.torque"]
        high = np.minimum(limit, np.maximum(stall * (1 - share), 0))
        low = -np.minimum(limit, np.maximum(stall * (1 + share), 0))
        # a safe torque has no more of it
        tolerance = 1e-6 * (1 + limit)
        assert (tick.tau <= high + tolerance).all()
        assert (tick.tau >= low - tolerance).all()
        if tick.status != Status.OK:
            continue
        solved += 1
        state = tick.reply[controller.format.reply.slice("active")][place]
        at_speed = np.abs(state) == RowState.AT_SPEED
        bound = np.where(state > 0, high, low)
        np.testing.assert_allclose(tick.tau[at_speed], bound[at_speed], atol=1e-5)
        assert (np.abs(bound) < limit)[at_speed].all()
        assert (np.abs(bound) == limit)[np.abs(state) == RowState.AT_BOUND].all()
        listed = {f"joint_torque_speed.{robot.joint_names[i]}" for i in np.flatnonzero(at_speed)}
        assert listed == {row for row in tick.active if row.startswith("joint_torque_speed")}
        named += len(listed)
    assert solved > 5
    assert named > 0


def with_lines(**lines: Any) -> Callable[[Any], object]:
    return lambda document: document.update(torque_speed=lines)


def test_a_file_gives_lines_by_pattern(write_robot: WriteRobot) -> None:
    slow = {"stall_torque": 500.0, "no_load_speed": 3.0}
    robot = load_robot(write_robot(with_lines(**{"._KFE": LINE, "R_KFE": slow})))
    left, right = (robot.joint_names.index(joint) for joint in ("L_KFE", "R_KFE"))
    assert (robot.stall_torque[left], robot.no_load_speed[left]) == (120.0, 8.0)
    assert (robot.stall_torque[right], robot.no_load_speed[right]) == (500.0, 3.0)
    assert np.isfinite(robot.stall_torque).sum() == 2
    lines = {line.joint: line for line in torque_speed_lines(robot)}
    limit = float(robot.torque_limit[right])
    assert lines["R_KFE"].full_torque_speed == pytest.approx(3.0 * (1 - limit / 500.0))
    assert lines["L_KFE"].full_torque_speed == 0.0  # stalls below its limit
    found = {finding.element for finding in unreachable_speeds(tuple(lines.values()))}
    assert robot.velocity_limit[left] > 8.0
    assert found == {"joint L_KFE", "joint R_KFE"}
    enough = load_robot(write_robot(with_lines(L_KFE={**LINE, "no_load_speed": 100.0})))
    assert not list(unreachable_speeds(torque_speed_lines(enough)))


@pytest.mark.parametrize(
    ("line", "field"),
    [
        ({"stall_torque": 0.0, "no_load_speed": 8.0}, "torque_speed.L_KFE.stall_torque"),
        ({"stall_torque": 120.0, "no_load_speed": -1.0}, "torque_speed.L_KFE.no_load_speed"),
        ({"stall_torque": 120.0}, "torque_speed.L_KFE.no_load_speed"),
        ({**LINE, "gear": 1.0}, "torque_speed.L_KFE.gear"),
    ],
)
def test_what_is_no_line_is_refused(
    line: dict[str, float], field: str, write_robot: WriteRobot
) -> None:
    with pytest.raises(RobotFileError, match=field):
        load_robot(write_robot(with_lines(L_KFE=line)))


def test_a_line_of_no_joint_is_refused(write_robot: WriteRobot) -> None:
    with pytest.raises(RobotFileError, match=r"torque_speed\.elbow.*matches no joint"):
        load_robot(write_robot(with_lines(elbow=LINE)))


def test_lines_change_neither_body_nor_formulation(robot: Robot, write_robot: WriteRobot) -> None:
    other = load_robot(write_robot(with_lines(L_KFE=LINE)))
    assert other.body_fingerprint == robot.body_fingerprint
    assert other.formulation_fingerprint == robot.formulation_fingerprint
