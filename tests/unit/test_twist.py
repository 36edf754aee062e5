"""The twist; what holds for every motion is in test_motions.py."""

from __future__ import annotations

import math

import pytest

from tsd_casadi import Robot
from tsd_casadi.motions.twist import Twist


def test_it_turns_about_the_vertical_axis_as_a_sine(robot: Robot) -> None:
    twist = Twist(0.05, 0.5)
    assert twist.axes(robot) == ("torso.rz",)
    for elapsed in (math.pi, 4.0, 7.5):
        reference, omega = twist.reference(elapsed), math.pi
        phase = twist.start_phase + elapsed
        assert reference.x == pytest.approx([0.05 * math.sin(phase)])
        assert reference.xd == pytest.approx([0.05 * omega * math.cos(phase)], abs=1e-12)
        assert reference.xdd == pytest.approx([-0.05 * omega**2 * math.sin(phase)], abs=1e-12)


def test_the_task_is_found_on_another_robot(mini_biped: Robot) -> None:
    assert Twist(0.01).axes(mini_biped) == ("upright.rz",)
