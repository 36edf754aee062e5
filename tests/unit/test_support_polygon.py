from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from tsd_casadi import Robot
from tsd_casadi.robot.reaching import reach
from tsd_casadi.robot.support_polygon import margin, support_polygon


def soles(robot: Robot, q: np.ndarray) -> np.ndarray:
    """All corners of the soles, written out."""
    corners = []
    for contact, sole in zip(robot.description.contacts, robot.sole_placements(q), strict=True):
        corners += [sole.act(np.array([x, y, 0.0]))[:2] for x in contact.x for y in contact.y]
    return np.array(corners)


@pytest.mark.parametrize("sway", [-0.11, -0.05, 0.0, 0.03, 0.11])
def test_it_is_the_hull_wherever_rounding_puts_the_corners(robot: Robot, sway: float) -> None:
    posture = reach(robot, robot.home, {"com.y": sway})
    assert posture is not None
    polygon = support_polygon(robot, posture.q)
    # both soles side by side: one rectangle
    assert len(polygon) == 4
    assert ConvexHull(polygon).volume == pytest.approx(ConvexHull(soles(robot, posture.q)).volume)


@given(st.floats(-np.pi, np.pi), st.floats(-1e3, 1e3))
def test_where_the_robot_stands_does_not_matter(angle: float, x: float) -> None:
    robot = shipped()
    q = robot.home.q.copy()
    q[0] += x
    half = 0.5 * angle
    q[3:7] = [0.0, 0.0, np.sin(half), np.cos(half)]
    polygon = support_polygon(robot, q)
    assert ConvexHull(polygon).volume == pytest.approx(ConvexHull(soles(robot, q)).volume, rel=1e-5)
    center = soles(robot, q).mean(axis=0)
    assert margin(polygon, center) == pytest.approx(0.1, abs=1e-6)
    assert margin(polygon, center + np.array([1.0, 0.0])) < 0


def shipped() -> Robot:
    from tsd_casadi import load_robot

    return load_robot("hermes_lower")
