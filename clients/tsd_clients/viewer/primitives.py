"""Triangles of simple bodies, about their own frame."""

from __future__ import annotations

import numpy as np

from tsd_casadi.state import Matrix, Vector
from tsd_clients.film.triangles import Faces

# sides of what is round
SIDES = 20
PLATE = 0.012  # m


def box(half: Vector) -> tuple[Matrix, Faces]:
    """Make a box.

    Args:
        half: Half of its edges, (3,) [m].
    """
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    # corners of their own for each side: its edges are sharp then
    vertices = np.vstack([corners[list(side)] for side in sides])
    faces = [(4 * k, 4 * k + a, 4 * k + a + 1) for k in range(6) for a in (1, 2)]
    return vertices, np.array(faces, dtype=np.int64)


def ellipsoid(radii: Vector) -> tuple[Matrix, Faces]:
    """Make an ellipsoid.

    Args:
        radii: (3,) [m].
    """
    heights = np.linspace(-np.pi / 2, np.pi / 2, SIDES // 2 + 1)
    vertices, faces = _turned(np.cos(heights), np.sin(heights))
    return vertices * radii, faces


def cylinder(radius: float, half: float) -> tuple[Matrix, Faces]:
    """Make a cylinder along z."""
    # rings twice where edges are sharp
    profile = np.array([0.0, radius, radius, radius, radius, 0.0])
    return _turned(profile, np.array([-half, -half, -half, half, half, half]))


def capsule(radius: float, half: float) -> tuple[Matrix, Faces]:
    """Make a cylinder along z with round ends."""
    heights = np.linspace(0, np.pi / 2, SIDES // 4 + 1)
    profile = radius * np.concatenate((np.cos(heights[::-1]), np.cos(heights)))
    height = np.concatenate(
        (-half - radius * np.sin(heights[::-1]), half + radius * np.sin(heights))
    )
    return _turned(profile, height)


def stick(end: Vector, radius: float) -> tuple[Matrix, Faces]:
    """Make a capsule from the origin to a point.

    Args:
        end: (3,) [m].
        radius: [m].
    """
    length = float(np.linalg.norm(end))
    vertices, faces = capsule(radius, length / 2)
    z = end / length
    x = np.cross(z, (1.0, 0, 0) if abs(z[0]) < 0.8 else (0, 1.0, 0))
    x /= np.linalg.norm(x)
    R = np.column_stack((x, np.cross(z, x), z))
    return (vertices + np.array([0, 0, length / 2])) @ R.T, faces


def plate(corners: Matrix) -> tuple[Matrix, Faces]:
    """Make a thin box around points in a plane.

    Args:
        corners: (c, 3) [m].
    """
    low, high = corners.min(axis=0), corners.max(axis=0)
    vertices, faces = box(np.maximum((high - low) / 2, PLATE / 2))
    return vertices + (low + high) / 2, faces


def _turned(profile: Vector, height: Vector) -> tuple[Matrix, Faces]:
    """Turn a line, radius over height from below, about z."""
    angles = 2 * np.pi * np.arange(SIDES) / SIDES
    rings = len(profile)
    vertices = np.column_stack(
        (
            np.outer(profile, np.cos(angles)).ravel(),
            np.outer(profile, np.sin(angles)).ravel(),
            np.repeat(height, SIDES),
        )
    )
    ring, side = (
        each.ravel() for each in np.meshgrid(range(rings - 1), range(SIDES), indexing="ij")
    )
    after = (side + 1) % SIDES
    a, b = ring * SIDES + side, ring * SIDES + after
    c, d = a + SIDES, b + SIDES
    faces = np.vstack((np.column_stack((a, b, d)), np.column_stack((a, d, c))))
    return vertices, faces.astype(np.int64)
