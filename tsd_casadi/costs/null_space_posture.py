r"""Posture in the null space of all Cartesian tasks and contacts [P_null, qdd_des].

.. math::

    \|P_{null} (\ddot q - \ddot q_{des})\|^2_{W_q}, \qquad
    P_{null} = I - J^T (J J^T + \delta I)^{-1} J, \qquad
    \ddot q_{des} = P_q (q_{ref} - q) - D_q \dot q

J stacks every active task **and every active contact**. Without the contact
rows the posture fights the contact forces, and learning converges several
times more slowly.
"""

from __future__ import annotations

import casadi as ca

# Keeps the projector finite where J loses rank (a straight knee); larger
# values let the posture leak into the tasks.
DAMPING = 1e-8


def null_space_projector(J: ca.MX) -> ca.MX:
    """Compute P_null of a Jacobian whose inactive rows are zero.

    Args:
        J: (rows, nv).

    Returns:
        (nv, nv), symmetric.
    """
    gram = J @ J.T + DAMPING * ca.MX.eye(J.shape[0])
    return ca.MX.eye(J.shape[1]) - J.T @ ca.solve(gram, J, "ldl")


def posture_acceleration(P_q: ca.SX, q_ref: ca.SX, D_q: ca.SX, q: ca.SX, v: ca.SX) -> ca.SX:
    """Compute qdd_des, which is zero on the base.

    Args:
        P_q: Stiffness, (n,) [1/s^2].
        q_ref: Joint angles, (n,) [rad].
        D_q: Damping, (n,) [1/s].
        q: Configuration, (7 + n,).
        v: Velocity, (6 + n,).

    Returns:
        (nv,) [rad/s^2].
    """
    return ca.vertcat(ca.SX.zeros(6), P_q * (q_ref - q[7:]) - D_q * v[6:])


def posture_cost(P_null: ca.MX, W_q: ca.MX, qdd_des: ca.MX) -> tuple[ca.MX, ca.MX]:
    """Write half the posture term in qdd as a Hessian and a gradient.

    Args:
        P_null: (nv, nv).
        W_q: Diagonal of the weight, (nv,).
        qdd_des: (nv,).

    Returns:
        H (nv, nv) and g (nv,).
    """
    H = P_null.T @ (ca.repmat(W_q, 1, P_null.shape[1]) * P_null)
    return H, -H @ qdd_des
