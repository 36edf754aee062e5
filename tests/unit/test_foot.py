from __future__ import annotations

import numpy as np
import pinocchio
import pytest

from tsd_casadi import Robot
from tsd_casadi.center_of_mass.pose_design import design_poses
from tsd_casadi.identification.regressor import free_motions
from tsd_casadi.robot.foot import Foot, Point, Sole, feet_jacobian
from tsd_casadi.robot.reaching import reach
from tsd_casadi.robot.standing import stand
from tsd_casadi.robot.support_polygon import margin, support_polygon


def moved(robot: Robot, seed: int = 0) -> np.ndarray:
    step = np.random.default_rng(seed).normal(scale=0.1, size=robot.nv)
    return np.asarray(pinocchio.integrate(robot.model, robot.home.q, step))


def test_a_robots_feet_are_of_its_contacts_kinds(
    robot: Robot, mini_quadruped: Robot, peg_leg: Robot
) -> None:
    kinds = [[type(foot) for foot in each.feet] for each in (robot, mini_quadruped, peg_leg)]
    assert kinds == [[Sole] * 2, [Point] * 4, [Point, Sole]]
    assert [foot.name for foot in peg_leg.feet] == ["far_tip", "near_ground"]


def test_the_error_to_where_it_is_is_none(any_robot: Robot) -> None:
    q, model, data = moved(any_robot), any_robot.model, any_robot.model.createData()
    feet_jacobian(any_robot.feet, model, data, q)
    for foot, place in zip(any_robot.feet, any_robot.sole_placements(q), strict=True):
        np.testing.assert_allclose(foot.error(data, place), np.zeros(foot.rows), atol=1e-12)


def test_jacobians_are_derivatives_of_the_errors(any_robot: Robot) -> None:
    q, model, data = moved(any_robot), any_robot.model, any_robot.model.createData()
    J, step = feet_jacobian(any_robot.feet, model, data, q), 1e-6
    assert J.shape == (sum(foot.rows for foot in any_robot.feet), any_robot.nv)
    for column, direction in enumerate(np.eye(any_robot.nv)):
        there = any_robot.sole_placements(pinocchio.integrate(model, q, step * direction))
        ahead = [foot.error(data, place) for foot, place in zip(any_robot.feet, there, strict=True)]
        np.testing.assert_allclose(np.concatenate(ahead) / step, J[:, column], atol=1e-5)


def test_a_point_may_turn_and_a_sole_may_not(peg_leg: Robot) -> None:
    q, data = peg_leg.home.q, peg_leg.model.createData()
    pinocchio.framesForwardKinematics(peg_leg.model, data, q)
    turn = pinocchio.SE3(pinocchio.exp3(np.array([0.1, 0.2, 0.3])), np.zeros(3))
    point, sole = peg_leg.feet
    places = [place * turn for place in peg_leg.sole_placements(q)]
    np.testing.assert_allclose(point.error(data, places[0]), 0, atol=1e-12)
    np.testing.assert_allclose(sole.error(data, places[1]), [0, 0, 0, 0.1, 0.2, 0.3], atol=1e-12)
    assert point.tilt(places[0]) == 0.0
    assert sole.tilt(places[1]) == pytest.approx(np.hypot(0.1, 0.2), rel=0.1)
    assert (len(point.normals(places[0])), len(sole.normals(places[1]))) == (0, 1)


def test_a_point_is_one_corner_of_the_support_polygon(
    mini_quadruped: Robot, peg_leg: Robot
) -> None:
    q = mini_quadruped.home.q
    points = [place.translation[:2] for place in mini_quadruped.sole_placements(q)]
    polygon = support_polygon(mini_quadruped, q)
    assert len(polygon) == 4
    assert all(min(np.linalg.norm(polygon - point, axis=1)) < 1e-9 for point in points)
    assert margin(polygon, mini_quadruped.home_com[:2]) > 0.05
    # rounded to nanometres; the point and the four corners of the sole
    assert len(support_polygon(peg_leg, peg_leg.home.q)) == 5
    tip = peg_leg.sole_placements(peg_leg.home.q)[0].translation[:2]
    assert min(np.linalg.norm(support_polygon(peg_leg, peg_leg.home.q) - tip, axis=1)) < 1e-9


def keeps_its_points(robot: Robot, q: np.ndarray) -> bool:
    places = zip(robot.sole_placements(q), robot.sole_placements(robot.home.q), strict=True)
    return all(np.abs(now.translation - then.translation).max() < 1e-6 for now, then in places)


@pytest.mark.parametrize("height", [-0.06, 0.03])
def test_standing_higher_keeps_points_and_lets_them_turn(
    height: float, mini_quadruped: Robot
) -> None:
    q = stand(mini_quadruped, height).q
    assert keeps_its_points(mini_quadruped, q)
    np.testing.assert_allclose(
        mini_quadruped.center_of_mass(q) - mini_quadruped.home_com, [0, 0, height], atol=1e-8
    )
    places = mini_quadruped.sole_placements(q)
    assert all(np.abs(place.rotation - np.eye(3)).max() > 0.01 for place in places)


def test_reaching_keeps_points(mini_quadruped: Robot) -> None:
    posture = reach(mini_quadruped, mini_quadruped.home, {"mass.x": 0.03, "level.rz": 0.1})
    assert posture is not None
    assert keeps_its_points(mini_quadruped, posture.q)
    moved = mini_quadruped.center_of_mass(posture.q) - mini_quadruped.home_com
    np.testing.assert_allclose(moved, [0.03, 0, 0], atol=1e-8)


def test_poses_to_measure_in_keep_points(mini_quadruped: Robot) -> None:
    poses = design_poses(mini_quadruped, 3)
    assert all(keeps_its_points(mini_quadruped, pose.q) for pose in poses)


def test_a_point_takes_three_ways_to_move(mini_quadruped: Robot, peg_leg: Robot) -> None:
    for robot, ways in ((mini_quadruped, 18 - 12), (peg_leg, 18 - 9)):
        q = moved(robot)
        Z = free_motions(robot, q)
        assert Z.shape == (robot.nv, ways)
        J = feet_jacobian(robot.feet, robot.model, robot.model.createData(), q)
        np.testing.assert_allclose(J @ Z, 0, atol=1e-9)
        np.testing.assert_allclose(Z[6:].T @ Z[6:], np.eye(ways), atol=1e-9)


def test_every_kind_names_its_rows(any_robot: Robot) -> None:
    kinds: set[type[Foot]] = {type(foot) for foot in any_robot.feet}
    assert kinds <= {Sole, Point}
    assert all(foot.rows in (3, 6) for foot in any_robot.feet)
