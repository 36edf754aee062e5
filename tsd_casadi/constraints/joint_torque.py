r"""Joint torques stay inside their limits.

.. math:: -\tau_{max} \le M_a \ddot q + h_a - J_{c,a}^T \lambda \le \tau_{max}
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from tsd_casadi.constraints.rows import Rows


def joint_torque(joints: Sequence[str], A_tau: ca.SX, h_a: ca.SX, limit: ca.SX) -> Rows:
    """Bound the torque of each joint, by one two-sided row.

    Args:
        A_tau: (n, nv + l) of tau = A_tau x + h_a.
        h_a: (n,) [N m].
        limit: tau_max, (n,) [N m].

    Returns:
        Rows -tau_max - h_a <= A_tau x <= tau_max - h_a.
    """
    return Rows(
        names=tuple(f"joint_torque.{joint}" for joint in joints),
        A=A_tau,
        lower=-limit - h_a,
        upper=limit - h_a,
    )
