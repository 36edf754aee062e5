"""Geometry of a link as points with radii: what touches the ground along any direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tsd_casadi.robot.collada import turn_of
from tsd_casadi.state import Matrix, Vector

# corners of the polygon that stands for a cylinder's rim: 5 mm off a rim of 1 m at most
RIM = 32
# a cylinder whose axis is further from straight down lies on its side, and touches the
# ground in a line as a capsule does (cosine of 45 degrees)
LYING = 0.7
# singular value, relative to the largest, below which points are in one plane
PLANAR = 1e-4


@dataclass(frozen=True)
class SweptPoints:
    """Points, each with a ball around it.

    Attributes:
        centers: In the frame of the link's joint, (k, 3) [m].
        radii: (k,) [m].
        kinds: What they came from, for messages.
    """

    centers: Matrix
    radii: Vector
    kinds: str

    def lowest(self, normal: Vector, tolerance: float) -> Matrix:
        """Find the points that are furthest along a direction.

        Args:
            normal: Unit vector, (3,).
            tolerance: How much less far still counts [m].

        Returns:
            On the balls' surfaces, (m, 3) [m].
        """
        reach = self.centers @ normal + self.radii
        chosen = reach >= reach.max() - tolerance
        points: Matrix = self.centers[chosen] + self.radii[chosen, None] * normal
        return points

    def facet_normals(self, count: int) -> list[Vector]:
        """Find outward normals of the largest facets of the centres' hull.

        Args:
            count: At most.

        Returns:
            Unit vectors, (3,) each, the largest facet's first; both normals of the
            plane if the centres lie in one, none if they lie on a line.
        """
        from scipy.spatial import ConvexHull

        spread = self.centers - self.centers.mean(axis=0)
        _, singular, axes = np.linalg.svd(spread, full_matrices=True)
        if len(self.centers) < 3 or singular[1] <= PLANAR * singular[0]:
            return []
        if len(self.centers) == 3 or singular[2] <= PLANAR * singular[0]:
            return [axes[2], -axes[2]]
        facets = ConvexHull(self.centers)
        corners = self.centers[facets.simplices]
        sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        sizes: dict[tuple[float, ...], float] = {}
        for normal, side in zip(facets.equations[:, :3], sides, strict=True):
            key = tuple(np.round(normal, 3))
            sizes[key] = sizes.get(key, 0.0) + float(np.linalg.norm(side))
        largest = sorted(sizes, key=lambda key: -sizes[key])[:count]
        return [np.array(key) / np.linalg.norm(key) for key in largest]


def points_of_link(model: Any, geometry: Any, frame: int, down: Vector) -> SweptPoints | None:
    """Collect the geometry of a link, or of what is fixed to it if it has none itself.

    Args:
        model: ``pinocchio.Model``.
        geometry: ``pinocchio.GeometryModel``.
        frame: Index of a link's frame, or of a frame on it.
        down: Where the foot's underside is, in the frame of its joint, (3,).

    Returns:
        In the frame of the joint that carries the link, or None if there is none.
    """
    joint = model.frames[frame].parentJoint
    rigid = [part for part in geometry.geometryObjects if part.parentJoint == joint]
    own = [part for part in rigid if part.parentFrame == frame]
    parts = own or rigid
    balls = [(part, *_balls(model, part, down)) for part in parts]
    balls = [(part, centers, radii) for part, centers, radii in balls if len(centers)]
    if not balls:
        return None
    centers = [
        local @ part.placement.rotation.T + part.placement.translation for part, local, _ in balls
    ]
    kinds = sorted({_kind(part.geometry) for part, _, _ in balls})
    return SweptPoints(
        np.vstack(centers), np.concatenate([radii for _, _, radii in balls]), " and ".join(kinds)
    )


def _kind(shape: Any) -> str:
    name = type(shape).__name__
    return "mesh" if name.startswith(("BVH", "Convex")) else name.lower()


def _balls(model: Any, part: Any, down: Vector) -> tuple[Matrix, Vector]:
    """Represent one shape by centres and radii in its own frame; none if it has no corners."""
    shape = part.geometry
    kind = type(shape).__name__
    if kind == "Box":
        signs = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
        return signs * np.array(shape.halfSide), np.zeros(8)
    if kind == "Sphere":
        return np.zeros((1, 3)), np.array([shape.radius])
    lies = abs(part.placement.rotation[:, 2] @ down) < LYING
    if kind == "Capsule" or (kind == "Cylinder" and lies):
        ends = np.array([[0, 0, -shape.halfLength], [0, 0, shape.halfLength]])
        return ends, np.full(2, shape.radius)
    if kind == "Cylinder":
        turn = np.linspace(0, 2 * np.pi, RIM, endpoint=False)
        rim = shape.radius * np.column_stack((np.cos(turn), np.sin(turn), 0 * turn))
        up = np.array([0, 0, shape.halfLength])
        return np.vstack((rim - up, rim + up)), np.zeros(2 * RIM)
    if kind.startswith("BVH"):
        vertices = np.array(shape.vertices())
        return vertices @ turn_of(model, part, vertices).T, np.zeros(len(vertices))
    if kind.startswith("Convex"):
        points = np.array(shape.points())
        return points, np.zeros(len(points))
    return np.zeros((0, 3)), np.zeros(0)
