"""Feet of a scene that is made in memory: boxes under soles, spheres at points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import SoleFile
from tsd_clients.simulator.ground import contact_options
from tsd_clients.simulator.undersides import find_undersides, sole_extents

# of a sole's box: inside any foot, and far deeper than a sole sinks in [m]
THICKNESS = 0.01
# of the sphere that touches in the point of a contact [m]
RADIUS = 0.01
COLOR = (0.20, 0.24, 0.30, 1.0)


def add_feet(robot: Robot, bodies: Sequence[Any]) -> None:
    """Add what touches the floor: one box or sphere per contact, nothing else collides.

    Args:
        bodies: ``MjsBody`` of each of Pinocchio's joints.
    """
    undersides = find_undersides(robot)
    homes = robot.sole_placements(robot.home.q)
    for contact, foot, home in zip(robot.description.contacts, robot.feet, homes, strict=True):
        frame = robot.model.frames[foot.frame]
        body, placement = bodies[frame.parentJoint], frame.placement * foot.upright(home)
        if isinstance(contact, SoleFile):
            bounds = np.array(sole_extents(contact, undersides[contact.name]))
            middle, half = bounds.mean(axis=1), np.ptp(bounds, axis=1) / 2
            size, center = (*half, THICKNESS / 2), (*middle, THICKNESS / 2)
            kind = mujoco.mjtGeom.mjGEOM_BOX
        else:
            size, center = (RADIUS, 0.0, 0.0), (0.0, 0.0, RADIUS)
            kind = mujoco.mjtGeom.mjGEOM_SPHERE
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(placement.rotation).ravel())
        body.add_geom(
            name=contact.name,
            type=kind,
            size=size,
            pos=placement.act(np.array(center)),
            quat=quaternion,
            mass=0.0,
            rgba=COLOR,
            # the floor's counterpart, and nothing else's
            contype=0,
            conaffinity=1,
            **contact_options(),
        )
