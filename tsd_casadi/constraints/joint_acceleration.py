r"""Joint accelerations stay inside their limits and what velocity and position make of them.

.. math:: -\ddot q_{max} \le \ddot q_a \le \ddot q_{max}

Where nothing satisfies all rows of the QP, the bounds that velocities make yield,
then those that positions make, too: each such row may lack an e, and
``YIELDING_WEIGHT`` e^2 / 2 joins the cost. A joint that then passes a bound that has
not yielded keeps that bound only. The acceleration limits themselves never yield.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from tsd_casadi.constraints.rows import BASE_AXES, INFINITY, AccelerationBounds, Rows

# of the square of what an acceleration lacks [s^4/rad^2]: as of a posture, a thousandth of
# a task. A foot that slaps down makes ankles faster than they may be, which no torque
# undoes: at 1e4 the whole body was thrown about for it.
YIELDING_WEIGHT = 1e-2


def joint_acceleration(
    joints: Sequence[str], limit: ca.SX, narrower: Sequence[AccelerationBounds], nx: int
) -> Rows:
    """Bound the first nv variables; the bounds of the base are infinite.

    No bound asks for more than the acceleration limit; where an upper one is below a
    lower one the upper counts.

    Args:
        limit: qdd_max, (n,) [rad/s^2].
        narrower: What else bounds the joints.
        nx: Size of x, nv + l.

    Returns:
        Rows whose A is the identity's first nv rows, as solvers take simple
        bounds.
    """
    lower, upper = -limit, limit
    for bounds in narrower:
        upper = ca.fmin(upper, bounds.upper)
        lower = ca.fmax(lower, bounds.lower)
    upper = ca.fmax(upper, -limit)
    lower = ca.fmin(lower, upper)
    base = INFINITY * ca.SX.ones(6)
    names = [f"joint_acceleration.base.{axis}" for axis in BASE_AXES]
    names += [f"joint_acceleration.{joint}" for joint in joints]
    return Rows(
        names=tuple(names),
        A=ca.SX.eye(nx)[: len(names), :],
        lower=ca.vertcat(-base, lower),
        upper=ca.vertcat(base, upper),
    )
