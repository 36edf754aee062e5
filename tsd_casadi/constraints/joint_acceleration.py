r"""Joint accelerations stay inside their limits.

.. math:: -\ddot q_{max} \le \ddot q_a \le \ddot q_{max}
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from tsd_casadi.constraints.rows import BASE_AXES, INFINITY, Rows


def joint_acceleration(joints: Sequence[str], limit: ca.SX, nx: int) -> Rows:
    """Bound the first nv variables; the bounds of the base are infinite.

    Args:
        limit: qdd_max, (n,) [rad/s^2].
        nx: Size of x, nv + l.

    Returns:
        Rows whose A is the identity's first nv rows, as solvers take simple
        bounds.
    """
    bound = ca.vertcat(INFINITY * ca.SX.ones(6), limit)
    names = [f"joint_acceleration.base.{axis}" for axis in BASE_AXES]
    names += [f"joint_acceleration.{joint}" for joint in joints]
    return Rows(names=tuple(names), A=ca.SX.eye(nx)[: len(names), :], lower=-bound, upper=bound)
