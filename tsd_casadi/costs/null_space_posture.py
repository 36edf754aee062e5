r"""Posture in the null space of all Cartesian tasks and contacts [P_null, qdd_des].

.. math::

    \|P_{null} (\ddot q - \ddot q_{des})\|^2_{W_q}, \qquad
    P_{null} = I - J^T (J J^T + \delta I)^{-1} J, \qquad
    \ddot q_{des} = P_q (q_{ref} - q) - D_q \dot q

J stacks every active task **and every active contact**. Without the contact
rows the posture fights the contact forces, and learning converges several
times more slowly.

Rows whose level s is between 0 and 1 are on their way in or out. Scaled rows would leave
P_null as it is until s is almost 0. So it goes over from the one to the other: with one
task of level s, P_null = (1 - s) P_without + s P_with, and with several

.. math:: P_{null} = (1 - s_{(1)}) I + \sum_i (s_{(i)} - s_{(i+1)}) P_i

where the rows are in the order of falling levels and P_i is the projection of the first i
of them: the Lovasz extension of rows that are there or not, which is continuous, and
where all levels are 0 or 1 the equation above. Weighted rows in an order of their own are
Liu, Tan and Padois' (Autonomous Robots 40, 2016, pages 17 to 31).
"""

from __future__ import annotations

import casadi as ca

# Keeps the projector finite where J loses rank (a straight knee); larger
# values let the posture leak into the tasks.
DAMPING = 1e-8


def null_space_projector(J: ca.MX, level: ca.MX) -> ca.MX:
    """Compute P_null of a Jacobian whose rows are there, not there or in between.

    The projection of one row more is Sherman and Morrison's update of the one before,
    R - u u^T / (delta + j^T u) with u = R j.

    Args:
        J: (rows, nv), zero where the level is 0.
        level: (rows,), 0 to 1.

    Returns:
        (nv, nv), symmetric.
    """
    rows, nv = J.shape
    order = _falling_order(rows)(level)
    J, level = order @ J, order @ level
    R, P_null = ca.MX.eye(nv), ca.MX.eye(nv)
    for i in range(rows):
        u = R @ J[i, :].T
        gone = u @ u.T / (DAMPING + J[i, :] @ u)
        R = R - gone
        P_null = P_null - level[i] * gone
    return P_null


def _falling_order(rows: int) -> ca.Function:
    """Write the permutation matrix that puts levels in falling order, equal ones as they are."""
    level = ca.SX.sym("level", rows)
    order = ca.SX(rows, rows)
    for i in range(rows):
        place = ca.sum1(level > level[i]) + ca.sum1(level[:i] == level[i])
        for row in range(rows):
            order[row, i] = place == row
    return ca.Function("falling_order", [level], [order])


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
