r"""What a failed tick answers with: gravity compensation and damping.

.. math::

    \tau_{safe} = \mathrm{clip}\left(g_a - J_{c,a}^T \lambda_g - D \dot q_a,
        \; \tau_{low}, \tau_{high}\right), \qquad
    \lambda_g = \arg\min \|\lambda\|^2 \;\text{s.t.}\; J_{c,u}^T \lambda = g_u

It needs no optimisation and no memory, so it exists whenever the state does.
"""

from __future__ import annotations

import casadi as ca

from tsd_casadi.constraints.torque_speed import TorqueBounds

# relative to the 6 x 6 Gram matrix of the base's contact Jacobian, whose
# entries are of the order of one
DAMPING = 1e-6


def safe_torque(
    gravity: ca.SX, J_c: ca.SX, v: ca.SX, damping: ca.SX, bounds: TorqueBounds
) -> ca.SX:
    """Compute the torque that holds the robot against gravity and takes out speed.

    Args:
        gravity: g, (nv,) [N, N m].
        J_c: Contact Jacobian, each contact times the square root of its share, (l, nv).
        v: Velocity, (nv,).
        damping: D, (n,) [N m s/rad].

    Returns:
        (n,) [N m], within the limits.
    """
    J_u = J_c[:, :6]
    gram = J_u.T @ J_u + DAMPING * ca.SX.eye(6)
    forces = J_u @ ca.solve(gram, gravity[:6])
    tau = gravity[6:] - J_c[:, 6:].T @ forces - damping * v[6:]
    return ca.fmin(ca.fmax(tau, bounds.lower), bounds.upper)
