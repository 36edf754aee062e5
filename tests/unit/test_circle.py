"""The circle; what holds for every motion is in test_motions.py."""

from __future__ import annotations

import numpy as np
import pytest

from tsd_casadi import Robot
from tsd_casadi.motions.circle import Circle


def test_it_stays_on_its_radius_and_turns_anticlockwise(robot: Robot) -> None:
    circle = Circle(0.02)
    assert circle.axes(robot) == ("com.x", "com.y")
    places = np.array([circle.reference(elapsed).x for elapsed in np.linspace(4.0, 10.0, 50)])
    assert np.linalg.norm(places, axis=1) == pytest.approx(np.full(50, 0.02))
    turned = places[:-1, 0] * places[1:, 1] - places[:-1, 1] * places[1:, 0]
    assert (turned > 0).all()
