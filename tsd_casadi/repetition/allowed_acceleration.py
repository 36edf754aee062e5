r"""How much acceleration the torque limits leave along an axis at a motion.

At each of some postures of the lap,

.. math:: a_{max} = \min_j \frac{\tau_{max,j} - |\tau_{0,j}|}{|k_j|}

with the torques :math:`\tau_0` that hold the robot at rest and the change k of them that
accelerates the axis by one while the feet stand and the other learned axes keep theirs:

.. math:: M \ddot q = S^T k + J_c^T \lambda, \quad J_c \ddot q = 0, \quad J \ddot q = e_{axis},

the one with the smallest norm of :math:`k_j / \tau_{max,j}`. The smallest of the lap counts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.motions.motion import Motion
from tsd_casadi.robot.reaching import reach
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import COM_AXES, FRAME_AXES
from tsd_casadi.robot.robot_file_tasks import ComTaskFile
from tsd_casadi.state import Matrix, Vector

# postures of a lap: its extremes are among them for every sinusoid
PHASES = 8
# how much larger accelerations [m/s^2, rad/s^2] and contact wrenches [N, N m] may be than
# shares of torque limits before they count as much: they are to be free
FREE = 1e6


def allowed_accelerations(robot: Robot, motion: Motion, axes: Sequence[str]) -> list[float]:
    """Compute what the torque limits leave along each axis.

    Args:
        axes: Learned axes, 'task.axis', k of them.

    Returns:
        (k,) [m/s^2, rad/s^2]; nothing where the motion is out of reach.
    """
    middle = motion.middle(robot)
    moved = motion.axes(robot)
    smallest = np.full(len(axes), np.inf)
    for index in range(PHASES):
        offset = motion.offset(motion.start_phase + 2 * math.pi * index / PHASES)
        posture = reach(robot, middle, dict(zip(moved, map(float, offset.x), strict=True)))
        if posture is not None:
            smallest = np.minimum(smallest, _allowed(robot, posture.q, axes))
    return smallest.tolist() if np.isfinite(smallest).all() else []


def _allowed(robot: Robot, q: Vector, axes: Sequence[str]) -> Vector:
    """Compute it in one posture, (k,)."""
    model, data = robot.model, robot.model.createData()
    upper = np.triu(pinocchio.crba(model, data, q))
    M = upper + np.triu(upper, 1).T
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.framesForwardKinematics(model, data, q)
    Jc = np.vstack([foot.jacobian(model, data) for foot in robot.feet])
    J = np.vstack([_jacobian(robot, data, q, axis) for axis in axes])
    limit = np.minimum(robot.torque_limit, robot.stall_torque)
    n, nv, m, k = robot.n, robot.nv, len(Jc), len(axes)
    S = np.hstack([np.zeros((n, nv - n)), np.eye(n)])
    # unknowns: accelerations, shares of the torque limits, wrenches
    A = np.zeros((nv + m + k, nv + n + m))
    A[:nv] = np.hstack([FREE * M, -S.T * limit, -FREE * Jc.T])
    A[nv : nv + m, :nv] = FREE * Jc
    A[nv + m :, :nv] = FREE * J
    wanted = np.zeros((len(A), k + 1))
    wanted[nv + m :, :k] = np.eye(k)
    wanted[:nv, k] = -pinocchio.computeGeneralizedGravity(model, data, q)
    shares = np.abs(np.linalg.lstsq(A, wanted, rcond=None)[0][nv : nv + n])
    left = np.maximum(0.0, 1 - shares[:, k:])
    with np.errstate(divide="ignore"):
        return np.asarray((left / shares[:, :k]).min(axis=0))


def _jacobian(robot: Robot, data: Any, q: Vector, axis: str) -> Matrix:
    """Compute the row of an axis, (1, nv), world axes."""
    name, _, along = axis.rpartition(".")
    task = next(each for each in robot.description.tasks if each.name == name)
    if isinstance(task, ComTaskFile):
        row = COM_AXES.index(along)
        return np.asarray(pinocchio.jacobianCenterOfMass(robot.model, data, q)[[row]])
    J = pinocchio.computeFrameJacobian(
        robot.model, data, q, robot.frame_id(name), pinocchio.LOCAL_WORLD_ALIGNED
    )
    return np.asarray(J[[FRAME_AXES.index(along)]])
