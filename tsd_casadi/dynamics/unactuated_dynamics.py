r"""The floating base's rows of the dynamics [un-actuated_dyn].

.. math:: M_u \ddot q + h_u = J_{c,u}^T \lambda
"""

from __future__ import annotations

import casadi as ca

from tsd_casadi.constraints.rows import BASE_AXES, Rows


def unactuated_dynamics(M: ca.SX, h: ca.SX, J_c: ca.SX) -> Rows:
    """Make (qdd, lambda) physically possible, by six equalities.

    Args:
        M: (nv, nv).
        h: (nv,) [N, N m].
        J_c: Contact Jacobian, (l, nv).

    Returns:
        Rows [M_u, -J_cu^T] x = -h_u, in the base frame.
    """
    A = ca.horzcat(M[:6, :], -J_c[:, :6].T)
    return Rows(
        names=tuple(f"unactuated_dynamics.{axis}" for axis in BASE_AXES),
        A=A,
        lower=-h[:6],
        upper=-h[:6],
        equality=True,
    )
