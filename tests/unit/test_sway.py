"""The sway; what holds for every motion is in test_motions.py."""

from __future__ import annotations

import math

import pytest

from tsd_casadi import Robot
from tsd_casadi.motions.sway import Sway


def test_it_goes_left_and_right_as_a_sine(robot: Robot) -> None:
    sway = Sway(0.05, 0.5)
    assert sway.axes(robot) == ("com.y",)
    for elapsed in (math.pi, 4.0, 7.5):
        reference, omega = sway.reference(elapsed), math.pi
        phase = sway.start_phase + elapsed
        assert reference.x == pytest.approx([0.05 * math.sin(phase)])
        assert reference.xd == pytest.approx([0.05 * omega * math.cos(phase)], abs=1e-12)
        assert reference.xdd == pytest.approx([-0.05 * omega**2 * math.sin(phase)], abs=1e-12)


def test_the_task_is_found_on_another_robot(mini_biped: Robot) -> None:
    assert Sway(0.01).axes(mini_biped) == ("mass.y",)
