r"""The joints' rows of the dynamics, which give the torque [actuated_dyn].

.. math:: \tau = M_a \ddot q + h_a - J_{c,a}^T \lambda
"""

from __future__ import annotations

import casadi as ca


def actuated_dynamics(M: ca.SX, h: ca.SX, J_c: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Write the torque as an affine function of x = (qdd, lambda).

    Args:
        M: (nv, nv).
        h: (nv,) [N, N m].
        J_c: Contact Jacobian, (l, nv).

    Returns:
        A_tau (n, nv + l) and h_a (n,) [N m] with tau = A_tau x + h_a.
    """
    return ca.horzcat(M[6:, :], -J_c[:, 6:].T), h[6:]
