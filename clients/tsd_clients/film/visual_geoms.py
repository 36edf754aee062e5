"""A description's visual shapes as MuJoCo's geoms, for pictures only."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import coal
import mujoco
import numpy as np

from tsd_casadi.robot.collada import turn_of
from tsd_casadi.robot.geometry import load_geometry
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, Vector
from tsd_clients.film.decimate import decimate
from tsd_clients.film.triangles import triangles

# MuJoCo takes 200,000 in a mesh
FACES = 100_000
# geoms of this group are not drawn unless asked for
HIDDEN = 3
# of a robot whose description shows nothing: a stick for each link [m]
STICK = 0.03
SHORTEST_STICK = 0.01
STICK_COLOR = (0.55, 0.60, 0.66, 1.0)


def add_visuals(spec: Any, robot: Robot, most_faces: int | None = None) -> tuple[str, ...]:
    """Add what the description shows of each link to the scene made of it.

    Args:
        spec: ``mujoco.MjSpec`` of ``build_scene``.
        most_faces: Of each mesh; larger ones are simplified.

    Returns:
        Mesh files that are missing, without which the picture has to do.
    """
    geometry = load_geometry(robot.bodies, "visual")
    shown = set()
    for number, shape in enumerate(geometry.model.geometryObjects):
        link = robot.bodies.link_of(shape.parentJoint)
        for options in _geoms(spec, robot, shape, f"visual {number}", most_faces):
            spec.body(link).add_geom(
                quat=_wxyz(shape.placement.rotation),
                rgba=_color(shape),
                contype=0,
                conaffinity=0,
                mass=0.0,
                **{"pos": shape.placement.translation, **options},
            )
            shown.add(link)
    if not shown:
        _add_sticks(spec, robot)
    for contact, frame in zip(robot.description.contacts, robot.sole_frames, strict=True):
        if robot.bodies.link_of(robot.model.frames[frame].parentJoint) in shown:
            spec.geom(contact.name).group = HIDDEN
    return geometry.missing


def _geoms(
    spec: Any, robot: Robot, shape: Any, name: str, most_faces: int | None
) -> Iterator[dict[str, Any]]:
    kind, types = shape.geometry, mujoco.mjtGeom
    if isinstance(kind, coal.Box):
        yield {"type": types.mjGEOM_BOX, "size": kind.halfSide}
    elif isinstance(kind, coal.Sphere):
        yield {"type": types.mjGEOM_SPHERE, "size": (kind.radius, 0.0, 0.0)}
    elif isinstance(kind, coal.Cylinder):
        yield {"type": types.mjGEOM_CYLINDER, "size": (kind.radius, kind.halfLength, 0.0)}
    elif isinstance(kind, coal.Capsule):
        yield {"type": types.mjGEOM_CAPSULE, "size": (kind.radius, kind.halfLength, 0.0)}
    elif isinstance(kind, coal.Ellipsoid):
        yield {"type": types.mjGEOM_ELLIPSOID, "size": kind.radii}
    elif isinstance(kind, coal.BVHModelBase):
        yield from _mesh(spec, robot, shape, name, most_faces)


def _mesh(
    spec: Any, robot: Robot, shape: Any, name: str, most_faces: int | None
) -> Iterator[dict[str, Any]]:
    vertices, faces = triangles(shape.geometry)
    if most_faces is not None:
        vertices, faces = decimate(vertices, faces, most_faces)
    vertices = vertices @ turn_of(robot.model, shape, vertices).T
    if np.prod(shape.meshScale) < 0:
        faces = faces[:, ::-1]  # what was outside is again
    # of vertices alone MuJoCo makes their hull
    parts = [faces[start : start + FACES] for start in range(0, len(faces), FACES)] or [faces]
    for number, part in enumerate(parts):
        used, local = np.unique(part, return_inverse=True)
        corners = vertices[used] if len(part) else vertices
        made = spec.add_mesh(
            name=f"{name}.{number}",
            uservert=corners.astype(np.float32).ravel(),
            # a picture needs no volume: open and flat meshes have none
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )
        if len(part):
            made.userface = local.astype(np.int32).ravel()
        yield {"type": mujoco.mjtGeom.mjGEOM_MESH, "meshname": made.name}


def _add_sticks(spec: Any, robot: Robot) -> None:
    model = robot.model
    for joint in range(2, model.njoints):
        end = model.jointPlacements[joint].translation
        if np.linalg.norm(end) > SHORTEST_STICK:
            spec.body(robot.bodies.link_of(model.parents[joint])).add_geom(
                type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                fromto=(0.0, 0.0, 0.0, *end),
                size=(STICK, 0.0, 0.0),
                rgba=STICK_COLOR,
                contype=0,
                conaffinity=0,
                mass=0.0,
            )


def _color(shape: Any) -> Vector:
    """Take a shape's colour; black or transparent is what exporters write for none."""
    color = np.array(shape.meshColor, dtype=float)
    return color if color[:3].any() and color[3] > 0 else np.array(STICK_COLOR)


def _wxyz(rotation: Matrix) -> Vector:
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    return quaternion
