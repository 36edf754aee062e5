r"""Joint torques stay inside their limits.

.. math:: \tau_{low} \le M_a \ddot q + h_a - J_{c,a}^T \lambda \le \tau_{high}
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from tsd_casadi.constraints.rows import Rows
from tsd_casadi.constraints.torque_speed import TorqueBounds


def joint_torque(joints: Sequence[str], A_tau: ca.SX, h_a: ca.SX, bounds: TorqueBounds) -> Rows:
    """Bound the torque of each joint, by one two-sided row.

    Args:
        A_tau: (n, nv + l) of tau = A_tau x + h_a.
        h_a: (n,) [N m].

    Returns:
        Rows lower - h_a <= A_tau x <= upper - h_a.
    """
    return Rows(
        names=tuple(f"joint_torque.{joint}" for joint in joints),
        A=A_tau,
        lower=bounds.lower - h_a,
        upper=bounds.upper - h_a,
    )
