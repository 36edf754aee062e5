"""Convex polygons in the plane: hull, area, and the largest upright rectangle inside."""

from __future__ import annotations

import numpy as np

from tsd_casadi.state import Matrix, Vector

# a turn smaller than this is none: points that differ by rounding are one [m^2]
STRAIGHT = 1e-12
DIGITS = 9  # of a corner [m]
# cuts of a polygon between which its largest rectangle is looked for: to 1 % of its length
CUTS = 101

Range = tuple[float, float]


def hull(points: Matrix) -> Matrix:
    """Compute a convex hull by Andrew's monotone chain: lower half, then upper half.

    Args:
        points: (k, 2).

    Returns:
        Corners, anticlockwise, (c, 2); fewer than three if the points are on a line.
    """
    # corners of an edge along y have the same x, but for rounding, which would order them
    # at random and have the chain below lose some
    ordered = sorted(set(map(tuple, np.round(points, DIGITS).tolist())))
    if len(ordered) < 3:
        return np.array(ordered).reshape(-1, 2)
    return np.array(_half(ordered) + _half(ordered[::-1]))


def area(polygon: Matrix) -> float:
    """Compute the area of a polygon, corners anticlockwise."""
    x, y = polygon.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def largest_rectangle(polygon: Matrix) -> tuple[Range, Range]:
    """Find the largest rectangle with sides along x and y inside a convex polygon.

    Returns:
        Its (low, high) along x and along y.
    """
    x = polygon[:, 0]
    cuts = np.unique(np.concatenate((x, np.linspace(x.min(), x.max(), CUTS))))
    crossings = [_crossings(polygon, cut) for cut in cuts]
    low = np.array([heights.min() for heights in crossings])
    high = np.array([heights.max() for heights in crossings])
    # convex: between two cuts the polygon is at least as wide as at the narrower end
    bottom = np.maximum(low[:, None], low[None, :])
    top = np.minimum(high[:, None], high[None, :])
    areas = (cuts[None, :] - cuts[:, None]) * np.maximum(top - bottom, 0.0)
    i, j = np.unravel_index(int(np.argmax(areas)), areas.shape)
    return (float(cuts[i]), float(cuts[j])), (float(bottom[i, j]), float(top[i, j]))


def _crossings(polygon: Matrix, cut: float) -> Vector:
    """Find where a polygon's boundary is at one x."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    left, right = np.minimum(start[:, 0], end[:, 0]), np.maximum(start[:, 0], end[:, 0])
    crossing = (left <= cut) & (cut <= right)
    start, end = start[crossing], end[crossing]
    run = end[:, 0] - start[:, 0]
    upright = run == 0
    share = np.where(upright, 0.0, (cut - start[:, 0]) / np.where(upright, 1.0, run))
    return np.concatenate((start[:, 1] + share * (end[:, 1] - start[:, 1]), end[upright, 1]))


def _half(ordered: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
    chain: list[tuple[float, ...]] = []
    for point in ordered:
        while len(chain) >= 2 and _turn(chain[-2], chain[-1], point) <= STRAIGHT:
            chain.pop()
        chain.append(point)
    return chain[:-1]


def _turn(a: tuple[float, ...], b: tuple[float, ...], c: tuple[float, ...]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
