"""Where a robot does not tip over: the hull of its soles and points."""

from __future__ import annotations

import numpy as np

from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, Vector

DIGITS = 9  # of a corner [m]


def support_polygon(robot: Robot, q: Vector) -> Matrix:
    """Compute the convex hull of the soles' rectangles and the points on the ground.

    Args:
        q: Configuration, shape (nq,), feet on the ground.

    Returns:
        Its corners, anticlockwise, (c, 2) [m], world frame.
    """
    places = zip(robot.feet, robot.sole_placements(q), strict=True)
    corners = np.vstack([foot.corners(place)[:, :2] for foot, place in places])
    # corners of an edge along y have the same x, but for rounding, which would order them
    # at random and have the chain below lose some
    return _hull(sorted({tuple(map(float, np.round(corner, DIGITS))) for corner in corners}))


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


def _hull(points: list[tuple[float, ...]]) -> Matrix:
    """Andrew's monotone chain: lower and upper half, from left to right and back."""

    def half(ordered: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
        chain: list[tuple[float, ...]] = []
        for point in ordered:
            while len(chain) >= 2 and _turn(chain[-2], chain[-1], point) <= 1e-12:
                chain.pop()
            chain.append(point)
        return chain[:-1]

    return np.array(half(points) + half(points[::-1]))


def _turn(a: tuple[float, ...], b: tuple[float, ...], c: tuple[float, ...]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
