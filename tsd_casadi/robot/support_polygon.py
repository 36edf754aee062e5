"""Where a robot does not tip over: the hull of its soles and points."""

from __future__ import annotations

import numpy as np

from tsd_casadi.robot.convex_polygon import hull
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, Vector


def support_polygon(robot: Robot, q: Vector) -> Matrix:
    """Compute the convex hull of the soles' rectangles and the points on the ground.

    Args:
        q: Configuration, shape (nq,), feet on the ground.

    Returns:
        Its corners, anticlockwise, (c, 2) [m], world frame.
    """
    places = zip(robot.feet, robot.sole_placements(q), strict=True)
    corners = np.vstack([foot.corners(place)[:, :2] for foot, place in places])
    return hull(corners)


def margin(polygon: Matrix, point: Vector) -> float:
    """Compute how far inside a polygon a point is.

    Args:
        polygon: Corners, anticlockwise, (c, 2) [m].
        point: (2,) [m].

    Returns:
        Distance to the nearest edge [m]; negative outside.
    """
    edges = np.roll(polygon, -1, axis=0) - polygon
    inwards = np.column_stack((-edges[:, 1], edges[:, 0]))
    inwards /= np.linalg.norm(inwards, axis=1, keepdims=True)
    return float(np.min(np.sum(inwards * (point - polygon), axis=1)))
