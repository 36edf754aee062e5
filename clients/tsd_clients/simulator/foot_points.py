"""The points of a geom that can be lowest: what a foot stands on."""

from __future__ import annotations

from itertools import product
from typing import Any

import mujoco
import numpy as np

from tsd_casadi.state import Matrix

# of a round rim
RIM = np.linspace(0, 2 * np.pi, 64, endpoint=False)


def foot_points(model: Any, data: Any, geom: int, frame: Any) -> Matrix:
    """List points whose lowest are the geom's lowest, seen from a frame.

    Args:
        model: ``mujoco.MjModel``.
        data: ``mujoco.MjData`` with kinematics.
        frame: ``pinocchio.SE3``, z up, in the world.

    Returns:
        (N, 3) [m], in the frame.
    """
    axes, place = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
    points, radius = _points(model, geom, axes.T @ frame.rotation[:, 2])
    points = (points @ axes.T + place - frame.translation) @ frame.rotation
    # round all about: lowest straight below
    points[:, 2] -= radius
    return np.asarray(points)


def _points(model: Any, geom: int, up: Any) -> tuple[Matrix, float]:
    """List points in the geom's frame, and the radius of the ball around each."""
    kind, size = model.geom_type[geom], model.geom_size[geom]
    types = mujoco.mjtGeom
    if kind == types.mjGEOM_BOX:
        return size * np.array(list(product((-1.0, 1.0), repeat=3))), 0.0
    if kind == types.mjGEOM_SPHERE:
        return np.zeros((1, 3)), float(size[0])
    if kind == types.mjGEOM_CAPSULE:
        return np.array([[0.0, 0.0, -size[1]], [0.0, 0.0, size[1]]]), float(size[0])
    if kind == types.mjGEOM_CYLINDER:
        circle = size[0] * np.column_stack((np.cos(RIM), np.sin(RIM)))
        ends = [np.column_stack((circle, np.full(len(RIM), end))) for end in (-size[1], size[1])]
        return np.vstack(ends), 0.0
    if kind == types.mjGEOM_ELLIPSOID:
        scaled = size * up
        return -(size * scaled / np.linalg.norm(scaled))[None, :], 0.0
    if kind == types.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first = int(model.mesh_vertadr[mesh])
        vertices = model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])]
        return np.asarray(vertices, dtype=float), 0.0
    return np.zeros((1, 3)), float(model.geom_rbound[geom])
