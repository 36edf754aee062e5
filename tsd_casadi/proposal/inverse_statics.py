r"""Joint torques of a posture on both soles, contact forces chosen with them.

.. math::

    \min_{\lambda \ge 0} \sum_j (\tau_j / \tau_{max,j})^2 \quad \text{with} \quad
    S^T \tau = M \ddot q + g - J^T G \lambda

where the columns of G are edges of friction pyramids at the soles' corners: the
centre of pressure stays inside, and nothing pulls.
"""

from __future__ import annotations

import numpy as np
import pinocchio

from tsd_casadi.proposal.body import Body
from tsd_casadi.state import Vector

# Coulomb coefficient that a proposed file counts on: rubber on a dusty floor
FRICTION = 0.5
# of the base's six rows, in shares of the robot's weight, against the joints' shares
EQUILIBRIUM = 1e3
# equilibrium missed by more than this share of the weight is none
BALANCED = 1e-3


def torque_shares(body: Body, q: Vector, acceleration: Vector) -> Vector | None:
    """Compute |torque| / limit of every joint where the robot stands or moves slowly.

    Args:
        q: Configuration, (nq,), soles flat.
        acceleration: Of all coordinates, (nv,).

    Returns:
        (n,), or None if no contact forces inside the friction cones balance the robot.
    """
    from scipy.optimize import nnls

    model, data = body.model, body.model.createData()
    tau = np.array(pinocchio.rnea(model, data, q, np.zeros(model.nv), acceleration))
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.framesForwardKinematics(model, data, q)
    columns = []
    for frame, sole in zip(body.sole_frames, body.soles, strict=True):
        J = np.array(pinocchio.getFrameJacobian(model, data, frame, pinocchio.LOCAL))
        for x in sole.x:
            for y in sole.y:
                for edge in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                    force = np.array([*(FRICTION / np.sqrt(2) * np.array(edge)), 1.0])
                    moment = np.cross([x, y, 0.0], force)
                    columns.append(J.T @ np.concatenate((force, moment)))
    weight = body.mass * 9.81
    scale = np.concatenate((np.full(6, EQUILIBRIUM / weight), 1.0 / body.limit))
    # forces in shares of the weight, so that columns are of one size
    matrix = scale[:, None] * np.column_stack(columns) * weight
    forces, _ = nnls(matrix, scale * tau, maxiter=50 * len(columns))
    left = scale * tau - matrix @ forces
    if np.abs(left[:6]).max() > EQUILIBRIUM * BALANCED:
        return None
    shares: Vector = np.abs(left[6:])
    return shares
