"""A moving squat whose controller goes away for good."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

from tsd_casadi import Controller, Robot, Squat, compile_controller

BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "held_posture.py"
_spec = importlib.util.spec_from_file_location("held_posture", BENCHMARK)
assert _spec is not None and _spec.loader is not None
held_posture = sys.modules["held_posture"] = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(held_posture)
hold = held_posture.hold

NEAR = 5e-3  # m


@pytest.mark.parametrize("error", [0.1, -0.1])
@pytest.mark.parametrize("share", [0.0, 0.25, 0.5, 0.75])
def test_hold_alone_stays_where_the_answers_stopped(
    robot: Robot, controller: Controller, error: float, share: float
) -> None:
    assert hold(robot, controller, Squat(0.04, 0.5), error, share).end <= NEAR


@pytest.mark.parametrize("error", [0.1, -0.1])
def test_hold_with_the_hardware_of_a_robot(
    robot: Robot, controller: Controller, error: float
) -> None:
    assert hold(robot, controller, Squat(0.04, 0.5), error, 0.5, hardware=["all"]).end <= NEAR


@pytest.mark.parametrize("error", [0.1, -0.1])
def test_hold_at_the_longest_period(robot: Robot, controller: Controller, error: float) -> None:
    assert hold(robot, controller, Squat(0.04, 0.5), error, 0.25, period=5e-3).end <= NEAR


@pytest.mark.parametrize("error", [0.1, -0.1])
def test_hold_of_a_robot_whose_legs_slide(mini_biped: Robot, error: float) -> None:
    controller = compile_controller(mini_biped)
    assert hold(mini_biped, controller, Squat(0.01, 0.5), error, 0.25).end <= NEAR
