r"""Joint velocities stay inside their limits at the next tick.

.. math:: -\dot q_{max} \le \dot q + T \ddot q \le \dot q_{max}

A joint that is faster is braked.
"""

from __future__ import annotations

import casadi as ca

from tsd_casadi.constraints.rows import AccelerationBounds, switched


def velocity_bounds(
    v: ca.SX, limit: ca.SX, braking: ca.SX, period: ca.SX, active: ca.SX
) -> AccelerationBounds:
    """Bound the acceleration by what the velocity may be one period later.

    Args:
        v: Joint velocities, (n,) [rad/s].
        limit: Of |v|, (n,) [rad/s].
        braking: Of a joint beyond its limit, (n,) [rad/s^2].
        period: Until the next tick [s].
        active: 0 for no bounds.

    Returns:
        Bounds that may exceed any acceleration limit.
    """
    return AccelerationBounds(
        lower=switched(active, ca.fmin((-limit - v) / period, braking), upper=False),
        upper=switched(active, ca.fmax((limit - v) / period, -braking), upper=True),
    )
