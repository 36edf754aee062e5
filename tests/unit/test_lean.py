"""The lean; what holds for every motion is in test_motions.py."""

from __future__ import annotations

import math

import pytest

from tsd_casadi import Robot
from tsd_casadi.motions.lean import Lean


def test_it_goes_forwards_and_back_as_a_sine(robot: Robot) -> None:
    lean = Lean(0.05, 0.5)
    assert lean.axes(robot) == ("com.x",)
    for elapsed in (math.pi, 4.0, 7.5):
        reference, omega = lean.reference(elapsed), math.pi
        phase = lean.start_phase + elapsed
        assert reference.x == pytest.approx([0.05 * math.sin(phase)])
        assert reference.xd == pytest.approx([0.05 * omega * math.cos(phase)], abs=1e-12)
        assert reference.xdd == pytest.approx([-0.05 * omega**2 * math.sin(phase)], abs=1e-12)


def test_the_task_is_found_on_another_robot(mini_biped: Robot) -> None:
    assert Lean(0.01).axes(mini_biped) == ("mass.x",)
