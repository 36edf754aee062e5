r"""A motor that turns fast has less torque left: a line from stall torque to no-load speed.

.. math:: \tau \le \min\left(\tau_{max},\;
    \tau_{stall} \max(0, 1 - \dot q / \dot q_{no load})\right)

and likewise the other way. Voltage bounds what drives; what brakes is bounded by
:math:`\tau_{max}` alone. Beyond the no-load speed nothing drives, but no row asks for a
torque that brakes.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca


@dataclass(frozen=True)
class TorqueBounds:
    """What the torques of the joints may be.

    Attributes:
        lower: (n,) [N m], not positive.
        upper: (n,) [N m], not negative.
    """

    lower: ca.SX
    upper: ca.SX


def torque_bounds(v: ca.SX, limit: ca.SX, stall: ca.SX, no_load: ca.SX) -> TorqueBounds:
    """Compute the bounds at a velocity.

    Args:
        v: Joint velocities, (n,) [rad/s].
        limit: tau_max, (n,) [N m].
        stall: Torque of the line at rest, (n,) [N m].
        no_load: Speed at which it is zero, (n,) [rad/s].
    """
    share = v / no_load
    # comparisons where fmax would be a call for each joint
    return TorqueBounds(
        lower=-ca.fmin(limit, (share > -1) * stall * (1 + share)),
        upper=ca.fmin(limit, (share < 1) * stall * (1 - share)),
    )
