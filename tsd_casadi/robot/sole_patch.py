r"""Where a foot is flat: the lowest plane of its geometry, and a rectangle in it.

Geometry is a set of points with radii, :math:`\{(p_i, r_i)\}`: corners of boxes,
vertices of meshes, centres of spheres, ends of capsules. Along a direction n that
points out of the foot the patch is

.. math:: \{p_i + r_i n : \max_j (n \cdot p_j + r_j) - (n \cdot p_i + r_i) \le 2\,\mathrm{mm}\}

and n is the one, of those that point down, whose patch has the largest hull.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.convex_polygon import area, hull, largest_rectangle
from tsd_casadi.robot.swept_points import SweptPoints, points_of_link
from tsd_casadi.state import Matrix, Vector

# meshes of soles are cast and chamfered: what is this near to the lowest plane is part
# of it, and a sole on a simulated floor sinks in by less [m]
FLATNESS = 2e-3
# a patch narrower than this is an edge or a point: it carries no moment worth planning
# with (a centimetre is 0.5 N m on each 100 N) [m]
LEAST_WIDTH = 0.01
DOWNWARD = 0.7  # cosine of 45 degrees: normals further from straight down are sides of the foot
# an axis of the link is taken if its patch is this share of the largest: a facet of a
# mesh tilted by its tolerance must not tilt the sole
AXIS_SHARE = 0.9
# an axis of the link this near to straight ahead is where the foot points (cosine of 20 degrees)
AHEAD = 0.94
# a frame of the description this near to the patch is the sole [m, rad]
COINCIDENT = 1e-3
FACETS = 20  # of a mesh's hull that are worth trying, the largest first
# the link's origin is the sole's, projected, if it is not at the edge of the rectangle
WELL_INSIDE = 0.9


@dataclass(frozen=True)
class SolePatch:
    """A flat patch under a foot.

    Attributes:
        frame: Link or frame of the description.
        index: Its index in the model.
        placement: ``pinocchio.SE3`` from that to the sole, z up, x forward; identity
            where ``frame`` is there already.
        x: Extent of the largest rectangle along x, in the sole's frame, (low, high) [m].
        y: Extent along y [m].
        outline: Corners of the whole patch, anticlockwise, in the sole's frame, (c, 2) [m].
        source: 'collision' or 'visual', the geometry that it was found in.
        named_height: Of the link's or frame's origin that was asked for, above the patch [m].
        from_ankle: How far the patch extends behind and ahead of the foot's last joint [m].
    """

    frame: str
    index: int
    placement: Any
    x: tuple[float, float]
    y: tuple[float, float]
    outline: Matrix
    source: str
    named_height: float
    from_ankle: tuple[float, float]

    @property
    def is_frame(self) -> bool:
        """Whether a frame of the description is the sole."""
        return bool(self.placement.isIdentity(0.0))


def find_sole_patch(
    path: Path,
    model: Any,
    geometries: Mapping[str, Any],
    frame: int,
    q: Vector,
    missing: Sequence[str] = (),
) -> SolePatch:
    """Find the lowest flat patch of a foot.

    Args:
        path: The description, for errors.
        model: ``pinocchio.Model``.
        geometries: ``pinocchio.GeometryModel`` by what it is for, 'collision' before
            'visual': the first with a patch is taken.
        frame: Index of the foot's link, or of a frame on it.
        q: Configuration, shape (nq,): upright, facing along the world's x axis, the feet
            within 45 degrees of flat.
        missing: Meshes that are not there, for the error.

    Raises:
        RobotFileError: If the foot has no geometry or none that is flat.
    """
    data = model.createData()
    pinocchio.forwardKinematics(model, data, q)
    upright = data.oMi[model.frames[frame].parentJoint]
    down = upright.rotation.T @ np.array([0.0, 0.0, -1.0])
    found = []
    for source, geometry in geometries.items():
        points = points_of_link(model, geometry, frame, down)
        if points is None:
            found.append(f"no {source} geometry")
            continue
        patch = _patch_of(points, upright)
        if patch is not None:
            return _placed(model, frame, patch, source)
        found.append(f"{source} geometry of {points.kinds}, which touches in a point or a line")
    if missing:
        found.append(f"meshes that are not there ({', '.join(missing)})")
    raise RobotFileError(
        path,
        f"link {model.frames[frame].name}",
        f"has {' and '.join(found)}",
        f"a foot with a patch flat to {1e3 * FLATNESS:g} mm and wider than "
        f"{1e3 * LEAST_WIDTH:g} mm: a box, a mesh, or at least three spheres; "
        "or a contact written by hand, a sole with offset, x and y, or 'type: point'",
    )


def _patch_of(points: SweptPoints, upright: Any) -> tuple[Any, Matrix] | None:
    """Find the sole's placement and outline, both in the joint's frame."""
    down, ahead = (upright.rotation.T @ axis for axis in np.array([[0, 0, -1.0], [1.0, 0, 0]]))
    axes = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    simple = [normal for normal in [down, *axes] if normal @ down > DOWNWARD]
    facets = [normal for normal in points.facet_normals(FACETS) if normal @ down > DOWNWARD]
    sized = [(_size(points, normal, ahead), normal) for normal in [*simple, *facets]]
    largest = max(size for size, _ in sized)
    if largest <= 0:
        return None
    wanted = [normal for size, normal in sized[: len(simple)] if size >= AXIS_SHARE * largest]
    best = [normal for size, normal in sized if size == largest]
    normal = [*wanted, *best][0]
    R = _axes(normal, ahead)
    lowest = points.lowest(normal, FLATNESS)
    outline = hull(lowest @ R[:, :2])
    rectangle = np.array(largest_rectangle(outline))
    center, half = rectangle.mean(axis=1), np.ptp(rectangle, axis=1) / 2
    # straight below the joint where that is under the foot: numbers that people recognise
    origin = np.where(np.abs(center) < WELL_INSIDE * half, 0.0, center)
    depth = float(np.max(lowest @ normal))
    return pinocchio.SE3(R, R @ np.array([*origin, -depth])), outline - origin


def _size(points: SweptPoints, normal: Vector, ahead: Vector) -> float:
    """Area of the patch along a normal, zero where it is too narrow for a sole [m^2]."""
    R = _axes(normal, ahead)
    outline = hull(points.lowest(normal, FLATNESS) @ R[:, :2])
    if len(outline) < 3:
        return 0.0
    extents = np.ptp(np.array(largest_rectangle(outline)), axis=1)
    return area(outline) if extents.min() >= LEAST_WIDTH else 0.0


def _axes(normal: Vector, ahead: Vector) -> Matrix:
    """Axes of a sole: z against the normal, x ahead or along an axis of the link near that."""
    z = -normal
    x = ahead - (ahead @ z) * z
    x /= np.linalg.norm(x)
    for axis in (sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)):
        flat = axis - (axis @ z) * z
        length = float(np.linalg.norm(flat))
        if length > AHEAD and flat @ x > AHEAD * length:
            x = flat / length
            break
    return np.column_stack((x, np.cross(z, x), z))


def _placed(model: Any, frame: int, patch: tuple[Any, Matrix], source: str) -> SolePatch:
    placement, outline = patch
    named = model.frames[frame]
    height = float(placement.actInv(named.placement).translation[2])
    ahead = outline[:, 0] - float(placement.actInv(np.zeros(3))[0])
    extent = (float(ahead.min()), float(ahead.max()))
    rigid = [i for i, each in enumerate(model.frames) if each.parentJoint == named.parentJoint]
    links = [i for i in rigid if model.frames[i].type == pinocchio.FrameType.BODY]
    for index in [frame, *links, *rigid]:
        offset = model.frames[index].placement.actInv(placement)
        if _coincides(offset):
            shifted = outline + offset.translation[:2]
            x, y = largest_rectangle(shifted)
            if x[0] < 0 < x[1] and y[0] < 0 < y[1]:
                name, here = str(model.frames[index].name), pinocchio.SE3.Identity()
                return SolePatch(name, index, here, x, y, shifted, source, height, extent)
    x, y = largest_rectangle(outline)
    offset = named.placement.actInv(placement)
    return SolePatch(str(named.name), frame, offset, x, y, outline, source, height, extent)


def _coincides(offset: Any) -> bool:
    """Whether a frame is in the plane of the patch with its axes, wherever in that plane."""
    turned = np.linalg.norm(pinocchio.log3(offset.rotation))
    return bool(max(abs(offset.translation[2]), turned) <= COINCIDENT)
