from __future__ import annotations

import numpy as np
import pinocchio
import pytest

from tsd_casadi import Robot
from tsd_clients.film.force_arrows import force_arrows


def _turned(robot: Robot, yaw: float) -> np.ndarray:
    """Home, turned about the vertical axis through the world's origin."""
    turn = pinocchio.SE3(pinocchio.utils.rotate("z", yaw), np.array([0.3, -0.2, 0.0]))
    q = robot.home.q.copy()
    base = turn * pinocchio.XYZQUATToSE3(q[:7])
    q[:7] = pinocchio.SE3ToXYZQUAT(base)
    return q


def test_a_weight_is_as_long_as_the_centre_of_mass_is_high(robot: Robot) -> None:
    half = [0.0, 0.0, 0.5 * robot.weight, 0.0, 0.0, 0.0]
    arrows = force_arrows(robot, robot.home.q, np.array(half * 2))
    for arrow, sole in zip(arrows, robot.sole_placements(robot.home.q), strict=True):
        assert arrow[0] == pytest.approx(sole.translation, abs=1e-12)
        assert arrow[1] - arrow[0] == pytest.approx([0, 0, 0.5 * robot.home_com[2]], abs=1e-9)


def test_an_arrow_begins_where_its_force_has_no_moment(robot: Robot) -> None:
    q = _turned(robot, 0.7)
    place = robot.sole_placements(q)[0]
    point = np.array([0.05, -0.02, 0.0])  # sole frame
    force = np.array([30.0, -20.0, 400.0])
    wrench = np.concatenate((force, np.cross(point, force)))
    arrow = force_arrows(robot, q, np.concatenate((wrench, np.zeros(6))))[0]
    assert arrow[0] == pytest.approx(place.act(point), abs=1e-9)
    along = (arrow[1] - arrow[0]) / np.linalg.norm(arrow[1] - arrow[0])
    assert along == pytest.approx(place.rotation @ force / np.linalg.norm(force), abs=1e-9)


def test_a_foot_in_the_air_has_no_arrow(robot: Robot) -> None:
    arrows = force_arrows(robot, robot.home.q, np.zeros(12))
    assert np.array_equal(arrows[:, 0], arrows[:, 1])


def test_forces_on_points_are_in_the_worlds_axes(peg_leg: Robot) -> None:
    q = _turned(peg_leg, 1.2)
    peg = [foot.rows for foot in peg_leg.feet].index(3)
    force = np.array([40.0, 0.0, 100.0])
    wrenches = np.zeros((2, 6))
    wrenches[peg, :3] = force
    start, tip = force_arrows(peg_leg, q, wrenches.ravel())[peg]
    assert start == pytest.approx(peg_leg.sole_placements(q)[peg].translation, abs=1e-12)
    assert tip - start == pytest.approx(force * peg_leg.home_com[2] / peg_leg.weight, abs=1e-9)
