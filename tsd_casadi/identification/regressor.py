r"""Equations that are linear in the inertial parameters, free of contact forces.

The dynamics are linear in the parameters :math:`\pi` of all links,
:math:`M \ddot q + h = Y(q, v, a) \pi`. Contact wrenches need not be measured:
with Z a basis of what the contacts leave free, :math:`J_c Z = 0`,

.. math:: Z^T Y \pi + Z^T S^T F(v) f = Z^T S^T \tau

holds whatever they are. Z is chosen so that :math:`S Z` has orthonormal columns
and every row has the noise of one joint torque. :math:`F f` is the friction of
the joints, viscous and Coulomb.
"""

from __future__ import annotations

import numpy as np
import pinocchio

from tsd_casadi.identification.observations import Observations, smooth_sign
from tsd_casadi.robot.foot import feet_jacobian
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, Vector


def nominal_parameters(robot: Robot) -> Vector:
    """List the parameters of all links as the robot's files have them.

    Returns:
        Mass [kg], first moments [kg m] and inertia about the joint's frame
        [kg m^2] of each joint's body, base first, (10 (n + 1),).
    """
    inertias = list(robot.model.inertias)[1:]
    return np.concatenate([inertia.toDynamicParameters() for inertia in inertias])


def free_motions(robot: Robot, q: Vector) -> Matrix:
    """Compute Z, the velocities that keep the feet still.

    Args:
        q: Configuration, (nq,).

    Returns:
        (nv, nv - l) with six rows l of each sole, three of each point; the joints'
        rows have orthonormal columns.
    """
    J = feet_jacobian(robot.feet, robot.model, robot.model.createData(), q)
    _, _, V = np.linalg.svd(J)
    Z = V[J.shape[0] :].T
    _, R = np.linalg.qr(Z[6:])
    return np.asarray(np.linalg.solve(R.T, Z.T).T)


def inertial_rows(robot: Robot, observed: Observations) -> tuple[Matrix, Vector]:
    """Write equations for the parameters of all links, free of contact wrenches.

    Returns:
        Z^T Y stacked over the samples, (rows, 10 (n + 1)), and Z^T S^T tau, (rows,).
    """
    data = robot.model.createData()
    blocks, sides = [], []
    for q, v, a, tau in zip(observed.q, observed.v, observed.a, observed.tau, strict=True):
        Z = free_motions(robot, q)
        Y = pinocchio.computeJointTorqueRegressor(robot.model, data, q, v, a)
        blocks.append(Z.T @ Y)
        sides.append(Z[6:].T @ tau)
    return np.vstack(blocks), np.concatenate(sides)


def friction_rows(robot: Robot, observed: Observations) -> Matrix:
    """Write the columns of the friction, Z^T S^T F, for viscous, then Coulomb coefficients.

    Returns:
        (rows, 2 n), rows as in ``inertial_rows``.
    """
    blocks = []
    for q, v in zip(observed.q, observed.v, strict=True):
        joints = v[6:]
        F = np.hstack((np.diag(joints), np.diag(smooth_sign(joints))))
        blocks.append(free_motions(robot, q)[6:].T @ F)
    return np.vstack(blocks)
