r"""Angular motion of a frame whose orientation is a rotation vector away from another.

With :math:`R = \exp([\theta]) R_0`, world axes, and :math:`t = \|\theta\|`,

.. math::

    \omega = J \dot\theta, \qquad \alpha = J \ddot\theta + \dot J \dot\theta, \qquad
    J = I + a [\theta] + b [\theta]^2, \quad
    a = \frac{1 - \cos t}{t^2}, \; b = \frac{t - \sin t}{t^3}

(Chirikjian, "Stochastic Models, Information Theory, and Lie Groups 2", section
10.7: the left Jacobian of SO(3)).
"""

from __future__ import annotations

import math

import numpy as np

from tsd_casadi.state import Vector

# below this angle the series are exact to rounding, and the quotients are not
SMALL = 1e-2  # rad


def quaternion_of(theta: Vector) -> Vector:
    """Compute the unit quaternion xyzw of a rotation vector, (4,).

    Args:
        theta: (3,) [rad].
    """
    x, y, z = theta.tolist()
    half = 0.5 * math.sqrt(x * x + y * y + z * z)
    # sin(half) / (2 half), by its series near 0
    share = 0.5 - half * half / 12 if half < 1e-4 else 0.5 * math.sin(half) / half
    return np.array((share * x, share * y, share * z, math.cos(half)))


def multiply(one: Vector, other: Vector) -> Vector:
    """Compute the product of two quaternions xyzw: first the other rotation, then the one, (4,)."""
    *x, a = one.tolist()
    *y, b = other.tolist()
    u, v, w = _cross(x, y)
    return np.array(
        (
            a * y[0] + b * x[0] + u,
            a * y[1] + b * x[1] + v,
            a * y[2] + b * x[2] + w,
            a * b - x[0] * y[0] - x[1] * y[1] - x[2] * y[2],
        )
    )


def angular_motion(theta: Vector, rate: Vector, rate_rate: Vector) -> tuple[Vector, Vector]:
    """Compute angular velocity and acceleration in world axes.

    Args:
        theta: Rotation vector, world axes, (3,) [rad].
        rate: Its derivative by time, (3,) [rad/s].
        rate_rate: Its second derivative, (3,) [rad/s^2].

    Returns:
        omega (3,) [rad/s] and alpha (3,) [rad/s^2].
    """
    t, d, dd = theta.tolist(), rate.tolist(), rate_rate.tolist()
    a, b, a_rate, b_rate = _coefficients(math.sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]))
    spin = t[0] * d[0] + t[1] * d[1] + t[2] * d[2]
    once, again = _cross(t, d), _cross(t, dd)
    twice, twice_again = _cross(t, once), _cross(t, again)
    drift = _cross(d, once)
    omega = [d[i] + a * once[i] + b * twice[i] for i in range(3)]
    alpha = [
        dd[i]
        + a * again[i]
        + b * (twice_again[i] + drift[i])
        + spin * (a_rate * once[i] + b_rate * twice[i])
        for i in range(3)
    ]
    return np.array(omega), np.array(alpha)


def _cross(x: list[float], y: list[float]) -> list[float]:
    # on three numbers each NumPy's own takes ten times as long
    return [
        x[1] * y[2] - x[2] * y[1],
        x[2] * y[0] - x[0] * y[2],
        x[0] * y[1] - x[1] * y[0],
    ]


def _coefficients(t: float) -> tuple[float, float, float, float]:
    """Compute a, b, and their derivatives by t over t."""
    if t < SMALL:
        t2 = t * t
        return (
            0.5 - t2 / 24,
            1 / 6 - t2 / 120,
            -1 / 12 + t2 / 180,
            -1 / 60 + t2 / 1260,
        )
    sine, cosine = math.sin(t), math.cos(t)
    return (
        (1 - cosine) / t**2,
        (t - sine) / t**3,
        (t * sine - 2 * (1 - cosine)) / t**4,
        (3 * sine - 2 * t - t * cosine) / t**5,
    )
