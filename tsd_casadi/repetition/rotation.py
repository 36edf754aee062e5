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
    half = 0.5 * math.sqrt(float(theta @ theta))
    # np.sinc is sin(pi x) / (pi x), 1 at 0
    return np.append(0.5 * np.sinc(half / math.pi) * theta, math.cos(half))


def multiply(one: Vector, other: Vector) -> Vector:
    """Compute the product of two quaternions xyzw: first the other rotation, then the one, (4,)."""
    x, y = one[:3], other[:3]
    return np.append(one[3] * y + other[3] * x + np.cross(x, y), one[3] * other[3] - x @ y)


def angular_motion(theta: Vector, rate: Vector, rate_rate: Vector) -> tuple[Vector, Vector]:
    """Compute angular velocity and acceleration in world axes.

    Args:
        theta: Rotation vector, world axes, (3,) [rad].
        rate: Its derivative by time, (3,) [rad/s].
        rate_rate: Its second derivative, (3,) [rad/s^2].

    Returns:
        omega (3,) [rad/s] and alpha (3,) [rad/s^2].
    """
    a, b, a_rate, b_rate = _coefficients(math.sqrt(float(theta @ theta)))
    spin = float(theta @ rate)
    once = np.cross(theta, rate)
    twice = np.cross(theta, once)
    omega = rate + a * once + b * twice
    alpha = rate_rate + a * np.cross(theta, rate_rate)
    alpha += b * np.cross(theta, np.cross(theta, rate_rate))
    alpha += a_rate * spin * once + b_rate * spin * twice + b * np.cross(rate, once)
    return omega, alpha


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
