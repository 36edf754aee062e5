"""How large a sole is: as its foot is flat, where the description tells without meshes.

Meshes are left out: a robot file must simulate the same with and without them.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pinocchio
from scipy.spatial import ConvexHull

from tsd_casadi.robot.checks import FLATNESS
from tsd_casadi.robot.geometry import load_primitives
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import SoleFile
from tsd_casadi.robot.swept_points import points_of_link
from tsd_casadi.state import Matrix

Extents = tuple[tuple[float, float], tuple[float, float]]

# narrower than this, points are on a line and carry no sole [m]
NARROW = 1e-6


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
    geometry = load_primitives(robot.bodies, links)
    return {
        contact.name: _underside(robot, geometry, index)
        for contact, index in zip(robot.description.contacts, robot.sole_frames, strict=True)
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


def _underside(robot: Robot, geometry: Any, frame: int) -> Matrix:
    sole = robot.model.frames[frame].placement
    down = -sole.rotation[:, 2]
    points = points_of_link(robot.model, geometry, frame, down)
    nothing: Matrix = np.empty((0, 2))
    if points is None:
        return nothing
    lowest = points.lowest(down, FLATNESS)
    in_sole = (lowest - sole.translation) @ sole.rotation
    return nothing if abs(in_sole[:, 2].min()) > FLATNESS else np.asarray(in_sole[:, :2])
