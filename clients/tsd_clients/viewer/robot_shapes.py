"""What a robot looks like, in few enough triangles for any browser."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import coal
import numpy as np

from tsd_casadi.robot.collada import turn_of
from tsd_casadi.robot.geometry import load_geometry
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, Vector
from tsd_clients.film.triangles import Faces, triangles
from tsd_clients.viewer import primitives

# of a whole robot: what is seen of one that fills a window; a tenth of what its meshes have,
# which a browser without a graphics card draws once in two seconds
BUDGET = 40_000
# a mesh that is this small already is left as it is
LEAST = 60
# nobody sees what is smaller from where a whole robot is seen [m]
CELL = 0.002
# a robot whose description shows nothing: a stick for each link [m]
STICK = 0.025
SHORTEST_STICK = 0.01
# exporters write black, white or nothing at all for 'no colour'
PLAIN = (0.62, 0.66, 0.71)


@dataclass(frozen=True)
class Shape:
    """Triangles of one colour that move with one joint.

    Attributes:
        joint: Its index in ``pinocchio.Model``.
        vertices: In the joint's frame, (k, 3) [m].
        faces: (m, 3).
        color: Red, green and blue, 0 to 1.
    """

    joint: int
    vertices: Matrix
    faces: Faces
    color: tuple[float, float, float]


def robot_shapes(robot: Robot, budget: int = BUDGET) -> list[Shape]:
    """Collect what the description shows of each link; sticks where it shows nothing.

    Args:
        budget: Number of triangles, about.

    Raises:
        RobotFileError: If a mesh that is there cannot be read.
    """
    found = list(_described(robot)) or list(_sticks(robot))
    share = min(1.0, budget / max(1, sum(len(shape.faces) for shape in found)))
    return _joined([_decimated(shape, share) for shape in found])


def _described(robot: Robot) -> Iterator[Shape]:
    for part in load_geometry(robot.bodies, "visual").model.geometryObjects:
        kind = part.geometry
        if isinstance(kind, coal.BVHModelBase):
            vertices, faces = triangles(kind)
            vertices = vertices @ turn_of(robot.model, part, vertices).T
            if np.prod(part.meshScale) < 0:
                faces = faces[:, ::-1]  # what was outside is again
        else:
            made = _primitive(kind)
            if made is None:
                continue
            vertices, faces = made
        if len(faces):
            placed = vertices @ part.placement.rotation.T + part.placement.translation
            yield Shape(part.parentJoint, placed, faces, _color(part))


def _primitive(kind: Any) -> tuple[Matrix, Faces] | None:
    if isinstance(kind, coal.Box):
        return primitives.box(kind.halfSide)
    if isinstance(kind, coal.Sphere):
        return primitives.ellipsoid(np.full(3, kind.radius))
    if isinstance(kind, coal.Ellipsoid):
        return primitives.ellipsoid(np.array(kind.radii))
    if isinstance(kind, coal.Cylinder):
        return primitives.cylinder(kind.radius, kind.halfLength)
    if isinstance(kind, coal.Capsule):
        return primitives.capsule(kind.radius, kind.halfLength)
    return None


def _sticks(robot: Robot) -> Iterator[Shape]:
    """Draw each link from its joint to the next ones, and what the feet stand on."""
    model = robot.model
    for joint in range(2, model.njoints):
        end = np.array(model.jointPlacements[joint].translation)
        if np.linalg.norm(end) > SHORTEST_STICK:
            yield Shape(model.parents[joint], *primitives.stick(end, STICK), PLAIN)
    for foot in robot.feet:
        frame = model.frames[foot.frame]
        end = np.array(frame.placement.translation)
        if np.linalg.norm(end) > SHORTEST_STICK:
            yield Shape(frame.parentJoint, *primitives.stick(end, STICK), PLAIN)
        corners = foot.corners(frame.placement)
        if len(corners) > 1:
            yield Shape(frame.parentJoint, *primitives.plate(corners), PLAIN)


def _decimated(shape: Shape, share: float) -> Shape:
    wanted = max(LEAST, round(share * len(shape.faces)))
    if wanted >= len(shape.faces):
        return shape
    vertices, faces = _welded(shape.vertices, shape.faces)
    if wanted < len(faces):
        import fast_simplification

        simple, faces = fast_simplification.simplify(
            vertices.astype(np.float32), faces.astype(np.int32), target_count=wanted
        )
        vertices = np.asarray(simple, dtype=float)
    return Shape(shape.joint, vertices, faces.astype(np.int64), shape.color)


def _welded(vertices: Matrix, faces: Faces) -> tuple[Matrix, Faces]:
    """Join vertices of one small cube: triangles of an STL share none by themselves.

    It also takes screws and fillets away, at which a decimation that keeps the
    shape's topology gets stuck with many times the triangles it was asked for.
    """
    cell = np.round(vertices / CELL).astype(np.int64)
    _, first, inverse = np.unique(cell, axis=0, return_index=True, return_inverse=True)
    faces = inverse.reshape(-1)[faces]
    faces = faces[(np.diff(np.sort(faces, axis=1), axis=1) > 0).all(axis=1)]
    _, once = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return vertices[first], faces[np.sort(once)]


def _joined(shapes: list[Shape]) -> list[Shape]:
    """Make one shape of those of a joint and colour: each costs the browser a call."""
    groups: dict[tuple[int, tuple[float, float, float]], list[Shape]] = {}
    for shape in shapes:
        groups.setdefault((shape.joint, shape.color), []).append(shape)
    joined = []
    for (joint, color), parts in groups.items():
        offsets = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
        vertices = np.vstack([part.vertices for part in parts])
        faces = np.vstack([part.faces + first for part, first in zip(parts, offsets, strict=True)])
        joined.append(Shape(joint, vertices, faces, color))
    return joined


def _color(part: Any) -> tuple[float, float, float]:
    color: Vector = np.array(part.meshColor, dtype=float)
    given = 0.0 < color[:3].sum() < 2.65 and color[3] > 0
    red, green, blue = color[:3] if given else PLAIN
    return float(red), float(green), float(blue)
