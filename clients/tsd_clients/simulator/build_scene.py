"""A MuJoCo scene made from the robot's Pinocchio model, in memory.

Bodies are Pinocchio's: one per joint, with everything that is fixed to it. What
keeps contacts stiff and repeatable is the same for every robot, so that a
simulation stays reproducible to micrometres.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pinocchio

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.inertias import ROUNDING
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, Vector
from tsd_clients.simulator.feet import add_feet
from tsd_clients.simulator.ground import add_floor

BASE_JOINT = "base"
TIMESTEP = 1e-3  # s
# friction this many times stiffer than normal forces: feet do not creep
IMPRATIO = 10.0
# a link without mass between two joints is allowed; MuJoCo wants more than
# 1e-15, and this much changes nothing that counts [kg, kg m^2]
LEAST = 1e-12
# of a flat body the largest moment of inertia is the sum of the others; MuJoCo
# refuses more than that, which rounded numbers may be by ``ROUNDING``. Relative
MARGIN = 1e-12
BASE = 1  # Pinocchio's first joint, the free-flyer


def build_scene(robot: Robot) -> Any:
    """Build a robot's scene: bodies, joints, torque motors, feet and a floor.

    Returns:
        ``mujoco.MjSpec``, to be compiled.

    Raises:
        RobotFileError: If a joint is neither revolute nor prismatic.
    """
    spec = mujoco.MjSpec()
    spec.modelname = robot.name
    spec.compiler.degree = False
    spec.option.timestep = TIMESTEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = IMPRATIO
    spec.option.gravity = robot.model.gravity.linear
    add_floor(spec)
    bodies = [spec.worldbody]
    for joint in range(BASE, robot.model.njoints):
        parent = bodies[robot.model.parents[joint]]
        bodies.append(_add_body(robot, joint, parent))
    for name, limit in zip(robot.joint_names, robot.torque_limit, strict=True):
        motor = spec.add_actuator(
            name=name,
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            ctrllimited=True,
            ctrlrange=(-limit, limit),
            forcelimited=True,
            forcerange=(-limit, limit),
        )
        motor.set_to_motor()
    add_feet(robot, bodies)
    return spec


def _add_body(robot: Robot, joint: int, parent: Any) -> Any:
    model = robot.model
    placement, inertia = model.jointPlacements[joint], model.inertias[joint]
    moments, axes = _principal(inertia.inertia)
    body = parent.add_body(
        name=robot.bodies.link_of(joint),
        pos=placement.translation,
        quat=_wxyz(placement.rotation),
        explicitinertial=True,
        mass=max(inertia.mass, LEAST),
        ipos=inertia.lever,
        inertia=moments,
        iquat=axes,
    )
    if joint == BASE:
        body.add_freejoint(name=BASE_JOINT)
        return body
    axis, kind = joint_axis(robot, joint)
    place = model.joints[joint].idx_q
    bounds = (model.lowerPositionLimit[place], model.upperPositionLimit[place])
    limited = bool(np.isfinite(bounds).all())
    body.add_joint(
        name=model.names[joint],
        type=kind,
        axis=axis,
        limited=limited,
        range=bounds if limited else (0.0, 0.0),
        armature=model.armature[model.joints[joint].idx_v],
    )
    return body


def joint_axis(robot: Robot, joint: int) -> tuple[Vector, Any]:
    """Find a joint's axis and kind.

    Args:
        joint: Pinocchio's index.

    Returns:
        Axis in the joint's frame, (3,), and ``mjJNT_HINGE`` or ``mjJNT_SLIDE``.

    Raises:
        RobotFileError: If the joint is neither revolute nor prismatic.
    """
    described = robot.model.joints[joint]
    if described.nq == described.nv == 1:
        data = described.createData()
        described.calc(data, pinocchio.neutral(robot.model))
        linear, angular = np.split(np.asarray(data.S, dtype=float).ravel(), 2)
        if not linear.any():
            return angular, mujoco.mjtJoint.mjJNT_HINGE
        if not angular.any():
            return linear, mujoco.mjtJoint.mjJNT_SLIDE
    raise RobotFileError(
        robot.path,
        f"joint {robot.model.names[joint]}",
        f"is of the kind {described.shortname()}, which is not simulated",
        "revolute and prismatic joints, others locked",
    )


def _wxyz(rotation: Matrix) -> Vector:
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    return quaternion


def _principal(inertia: Matrix) -> tuple[Vector, Vector]:
    """Decompose an inertia, more precisely than every release of MuJoCo does.

    Returns:
        Principal moments that MuJoCo takes, (3,), and the quaternion wxyz of their axes.
    """
    moments, axes = np.linalg.eigh(inertia)
    least, middle, largest = moments
    lacking, added = largest - middle - least, 0.0
    if -MARGIN * largest < lacking < 2 * ROUNDING * largest:
        added = lacking + 2 * MARGIN * largest
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])  # right-handed
    return moments + max(added, LEAST - least, 0.0), _wxyz(axes)
