"""The benchmark of feet that come and go, on the smallest robots."""

from __future__ import annotations

import pytest

from benchmarks.contacts import FALLEN, LARGEST_CHANGE, RAMP, level, run
from tsd_casadi import Robot, compile_controller


def test_levels_of_a_ramp_and_of_a_switch() -> None:
    assert [level(t, RAMP) for t in (2.0, 2.4, 2.6, 3.1, 3.5)] == pytest.approx([1, 0.5, 0, 0.5, 1])
    assert [level(t, 0.0) for t in (2.29, 2.31, 2.99, 3.01)] == [1, 0, 0, 1]
    assert FALLEN < 1


def test_a_ramp_keeps_torques_from_jumping(mini_quadruped: Robot) -> None:
    controller = compile_controller(mini_quadruped, on_compile=lambda: None)
    ramped = run(mini_quadruped, controller, "fl_ground", RAMP)
    switched = run(mini_quadruped, controller, "fl_ground", 0.0)
    assert not ramped.fell
    assert ramped.largest_change <= LARGEST_CHANGE
    assert switched.largest_change > 2 * LARGEST_CHANGE
    assert abs(ramped.force[ramped.active == 0]).max() < 1e-9
