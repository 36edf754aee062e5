r"""Joint positions stay inside their limits, and can be kept there by braking.

With d the way to a limit, b the braking acceleration and T the period, the next
velocity s towards the limit is bounded so that braking at b stops before it,

.. math:: T s + \frac{s^2}{2 b} \le d \quad\Leftrightarrow\quad
    s \le \frac{2 d}{T + \sqrt{T^2 + 2 d / b}},

which makes (s - v) / T a bound of the acceleration. A. Del Prete, "Joint position
and velocity bounds in discrete-time acceleration/torque control of robot
manipulators", RA-L 2018, asks for the same of a robot whose acceleration a is
constant over a period: q + T v + T^2 a / 2. Here the next position is that of the
semi-implicit step, q + T (v + T a), as simulators take it, because its bound settles
at the limit where the other one alternates. A robot whose acceleration is constant
goes further than that, over all of a braking by 5/8 b T^2 at most; the way to the
limit is counted ``MARGIN`` b T^2 short, so that neither of the two passes it.
"""

from __future__ import annotations

import casadi as ca

from tsd_casadi.constraints.rows import AccelerationBounds, switched

# of b T^2; 5/8 is the most that a robot of constant acceleration needs: 1/2 while it
# brakes, 1/8 in the period in which it turns round
MARGIN = 0.75
# of a joint's range, where a long period would make the margins all of it
LARGEST_MARGIN = 0.1
# how fast a joint comes back from beyond its limit [s]: 1e-3 rad take 10 rad/s^2 of
# the first period of 1 ms, which legs under load have to spare
RETURN_TIME = 0.1
# where a request asks for no acceleration at all, so that nothing is divided by zero [rad/s^2]
LEAST_BRAKING = 1e-6


def position_bounds(
    q: ca.SX,
    v: ca.SX,
    lower: ca.SX,
    upper: ca.SX,
    braking: ca.SX,
    period: ca.SX,
    active: ca.SX,
) -> AccelerationBounds:
    """Bound the acceleration so that the joint can stop before its limits.

    Args:
        q: Joint angles, (n,) [rad].
        v: Joint velocities, (n,) [rad/s].
        lower: Of q, (n,) [rad].
        upper: Of q, (n,) [rad].
        braking: What a joint can count on to stop, (n,) [rad/s^2].
        period: Until the next tick [s].
        active: 0 for no bounds.

    Returns:
        Bounds that may exceed any acceleration limit.
    """
    b = ca.fmax(braking, LEAST_BRAKING)
    margin = ca.fmin(MARGIN * b * period**2, LARGEST_MARGIN * (upper - lower))
    towards_upper = _next_velocity(upper - margin - q, v, b, period)
    towards_lower = _next_velocity(q - lower - margin, -v, b, period)
    return AccelerationBounds(
        lower=switched(active, (-towards_lower - v) / period, upper=False),
        upper=switched(active, (towards_upper - v) / period, upper=True),
    )


def _next_velocity(d: ca.SX, v: ca.SX, b: ca.SX, period: ca.SX) -> ca.SX:
    """Largest next velocity towards a limit; beyond it, that of coming back.

    What moves on beyond is stopped at once, and comes back at no more than b.
    """
    inside = ca.fmax(d, 0)
    braked = 2 * inside / (period + ca.sqrt(period**2 + 2 * inside / b))
    returning = ca.fmax(ca.fmin(d, 0) / RETURN_TIME, ca.fmin(v, 0) - b * period)
    return braked + returning
