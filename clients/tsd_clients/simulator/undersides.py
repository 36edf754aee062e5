"""How large a sole is: as its foot is flat, where the description tells without meshes.

Meshes are left out: a robot file must simulate the same with and without them.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import coal
import numpy as np
import pinocchio
from scipy.spatial import ConvexHull

from tsd_casadi.robot.checks import FLATNESS
from tsd_casadi.robot.geometry import load_primitives
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import SoleFile
from tsd_casadi.state import Matrix, Vector

Extents = tuple[tuple[float, float], tuple[float, float]]

# narrower than this, points are on a line and carry no sole [m]
NARROW = 1e-6
# of a cylinder's rim
RIM = np.linspace(0, 2 * np.pi, 64, endpoint=False)


def find_undersides(robot: Robot) -> dict[str, Matrix]:
    """Find the points that each foot stands on.

    Returns:
        By contact, in its frame, (k, 2) [m]; none where the description has no shape
        there whose lowest points are at the contact's height.
    """
    frames = [robot.model.frames[index] for index in robot.sole_frames]
    joints = {frame.parentJoint for frame in frames}
    links = [
        frame.name
        for frame in robot.model.frames
        if frame.parentJoint in joints and frame.type == pinocchio.FrameType.BODY
    ]
    shapes = load_primitives(robot.bodies, links).geometryObjects
    return {
        contact.name: _underside(
            [shape for shape in shapes if shape.parentJoint == frame.parentJoint], frame.placement
        )
        for contact, frame in zip(robot.description.contacts, frames, strict=True)
    }


def sole_extents(contact: SoleFile, underside: Matrix) -> Extents:
    """Widen the sole that the controller counts on to what the foot is.

    Each side moves out, forwards first, as far as the corners stay on the foot.

    Args:
        underside: (k, 2) [m], in the contact's frame.

    Returns:
        (low, high) along x and along y, never less than the controller's [m].
    """
    bounds = np.array([contact.x, contact.y])
    if not len(underside) or np.linalg.matrix_rank(underside - underside[0], NARROW) < 2:
        return contact.x, contact.y
    # inside where normals @ place <= reach
    normals, reach = np.split(ConvexHull(underside).equations, [2], axis=1)
    for axis, end in product((0, 1), (1, 0)):
        along, across = normals[:, axis], normals[:, 1 - axis, None]
        furthest = (across * bounds[1 - axis]).max(axis=1)
        facing = along > 0 if end else along < 0
        place = (-reach[:, 0] - furthest)[facing] / along[facing]
        bounds[axis, end] = (
            max(bounds[axis, 1], place.min()) if end else min(bounds[axis, 0], place.max())
        )
    (x, X), (y, Y) = bounds.tolist()
    return (x, X), (y, Y)


def _underside(shapes: list[Any], sole: Any) -> Matrix:
    placed = [_points(shape.geometry) for shape in shapes]
    points = [np.empty((0, 3))]
    for shape, (local, radius) in zip(shapes, placed, strict=True):
        offset = sole.actInv(shape.placement)
        below = local @ offset.rotation.T + offset.translation
        points.append(below - [0.0, 0.0, radius])
    together = np.vstack(points)
    if not len(together) or abs(float(together[:, 2].min())) > FLATNESS:
        return np.empty((0, 2))
    return np.asarray(together[together[:, 2] < together[:, 2].min() + FLATNESS, :2])


def _points(shape: Any) -> tuple[Matrix, float]:
    """List the corners of a shape, and the radius of the ball around each."""
    nothing: Vector = np.zeros((1, 3))
    if isinstance(shape, coal.Box):
        return np.array(list(product((-1.0, 1.0), repeat=3))) * shape.halfSide, 0.0
    if isinstance(shape, coal.Sphere):
        return nothing, float(shape.radius)
    if isinstance(shape, coal.Capsule):
        return shape.halfLength * np.array([[0, 0, -1.0], [0, 0, 1.0]]), float(shape.radius)
    if isinstance(shape, coal.Cylinder):
        circle = shape.radius * np.column_stack((np.cos(RIM), np.sin(RIM)))
        ends = (-shape.halfLength, shape.halfLength)
        return np.vstack([np.column_stack((circle, np.full(len(RIM), z))) for z in ends]), 0.0
    return np.empty((0, 3)), 0.0
