r"""How the closed loop answers a change of the feedforward.

Along one axis of a task, the robot's position x obeys, near its reference and
up to a disturbance that repeats from lap to lap,

.. math:: s^2 x = \alpha e^{-\tau s} \ddot x_{des} + d, \qquad
    \ddot x_{des} = \ddot x_{ref} + u + C (x_{ref} - x), \quad C(s) = P + D s

with the feedforward u, a gain :math:`\alpha` (1 for a perfect model) and a
delay :math:`\tau` (actuator lag, transport and filters together). With
e = x_ref - x, a change of u from one repetition to the next changes e by

.. math:: 0 = \alpha e^{-\tau s} (\Delta u + C \Delta e) + s^2 \Delta e,

and the feedback C e by -T times the change of u, where

.. math:: T(s) = \frac{C G}{1 + C G}, \qquad G(s) = \alpha e^{-\tau s} / s^2 .

Gain and delay are estimated from recorded repetitions by least squares on the
equation above, with a prior that decides as long as there is only one. Where
the required acceleration depends on the position, :math:`k \Delta e` adds to
it; k is estimated with them lest the gain makes up for it, and then forgotten:
what to learn from the position is a matter of ``task_dynamics``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tsd_casadi.encoding.harmonics import Harmonics
from tsd_casadi.state import Vector

# what is known before anything was recorded: a model right within some ten per
# cent, and some milliseconds from command to torque
PRIOR_GAIN, PRIOR_GAIN_DEVIATION = 1.0, 0.1
PRIOR_DELAY, PRIOR_DELAY_DEVIATION = 0.005, 0.005  # s
# how strongly the required acceleration may depend on where the robot is [1/s^2]
SPRING_DEVIATION = 10.0
# what the linear equation leaves unexplained: a floor [m/s^2], and a share of
# all harmonics together, since friction mixes them. The share is some times what
# even the best gain and delay leave (which had been free to fit it), at most this
FLOOR = 0.01
LARGEST_SHARE = 0.3
SHARE_PER_RESIDUAL = 3.0
# delays among which the best is sought, before it is refined between them [s]
DELAY_STEP = 0.002
DELAYS = np.arange(0.0, 0.0601, DELAY_STEP)


@dataclass(frozen=True)
class LoopResponse:
    """The estimated response.

    Attributes:
        gain: alpha.
        delay: tau [s].
        gain_deviation: Standard deviation of the gain.
        delay_deviation: Standard deviation of the delay [s].
    """

    gain: float = PRIOR_GAIN
    delay: float = PRIOR_DELAY
    gain_deviation: float = PRIOR_GAIN_DEVIATION
    delay_deviation: float = PRIOR_DELAY_DEVIATION

    def transfer(self, omega: Vector, P: float, D: float) -> Harmonics:
        """Compute T at some angular frequencies.

        Args:
            omega: (N + 1,) [rad/s].
            P: Stiffness [1/s^2].
            D: Damping [1/s].

        Returns:
            (N + 1,); 1 at rest.
        """
        C = P + 1j * omega * D
        CG = C * self.gain * np.exp(-1j * omega * self.delay)
        return np.asarray(CG / (CG - omega**2))


def estimate_response(
    feedforward: Harmonics,
    errors: Harmonics,
    omega: Vector,
    P: float,
    D: float,
) -> LoopResponse:
    """Estimate gain and delay from repetitions of one motion.

    Args:
        feedforward: Harmonics of u, one row per repetition, (r, N + 1) [m/s^2].
        errors: Harmonics of e, one row per repetition, (r, N + 1) [m].
        omega: Angular frequency of each harmonic, (N + 1,) [rad/s].
        P: Stiffness [1/s^2].
        D: Damping [1/s].

    Returns:
        The response; the prior if there is only one repetition.
    """
    if len(feedforward) < 2:
        return LoopResponse()
    from scipy.optimize import least_squares

    C = P + 1j * omega * D
    change_e = np.diff(errors, axis=0)
    change_a = np.diff(feedforward, axis=0) + C * change_e
    share = min(LARGEST_SHARE, SHARE_PER_RESIDUAL * _unexplained(change_a, change_e, omega))
    scale = FLOOR + share * np.linalg.norm(change_a, axis=1, keepdims=True)

    def residual(unknown: Vector) -> Vector:
        gain, delay, spring = unknown
        left = gain * np.exp(-1j * omega * delay) * change_a - (omega**2 - spring) * change_e
        whitened = (left / scale).ravel()
        prior = (
            (gain - PRIOR_GAIN) / PRIOR_GAIN_DEVIATION,
            (delay - PRIOR_DELAY) / PRIOR_DELAY_DEVIATION,
            spring / SPRING_DEVIATION,
        )
        return np.concatenate((whitened.real, whitened.imag, prior))

    start = (PRIOR_GAIN, PRIOR_DELAY, 0.0)
    found = least_squares(residual, start, x_scale=(0.1, 0.005, 10.0))
    covariance = np.linalg.inv(found.jac.T @ found.jac)
    deviations = np.sqrt(np.diag(covariance))
    return LoopResponse(*map(float, found.x[:2]), *map(float, deviations[:2]))


def _unexplained(change_a: Harmonics, change_e: Harmonics, omega: Vector) -> float:
    """Compute the share of the changes that no gain, delay and spring explain, 0 to 1."""
    from scipy.optimize import minimize_scalar

    power = float(np.linalg.norm(change_a))
    if power == 0.0:
        return 1.0
    wanted = _real(omega**2 * change_e)

    def left(delay: float) -> float:
        known = np.column_stack((_real(np.exp(-1j * omega * delay) * change_a), _real(change_e)))
        coefficients = np.linalg.lstsq(known, wanted, rcond=None)[0]
        return float(np.linalg.norm(known @ coefficients - wanted))

    # half a step off at the highest harmonic would count as much as noise does
    coarse = DELAYS[np.argmin([left(delay) for delay in DELAYS])]
    bounds = (max(0.0, coarse - DELAY_STEP), coarse + DELAY_STEP)
    finest = minimize_scalar(left, bounds=bounds, method="bounded", options={"xatol": 1e-6})
    return min(float(finest.fun), left(float(coarse)), power) / power


def _real(values: Harmonics) -> Vector:
    return np.concatenate((values.real.ravel(), values.imag.ravel()))
