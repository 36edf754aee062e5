r"""Phase lead and bandwidth of iterative learning.

The feedforward of the next repetition is, harmonic by harmonic,

.. math:: u_{i+1} = Q \, (u_i + L \, C e_i), \qquad
    L = 1 + \frac{s^2}{C} \frac{e^{l s}}{\hat\alpha}

With the plain sum, L = Q = 1, what is left of an error shrinks by |1 - T| per
iteration, which lag and delay push above one from some harmonic on: it grows
there, slowly and without bound. L is the inverse of the estimated response
``loop_response`` with the lead l equal to the estimated delay: it brings

.. math:: \rho_n = | Q_n (1 - L_n T_n) |

near zero. Q is one up to the last harmonic at which :math:`\rho_n` stays below
``LARGEST_CONTRACTION`` for every response that the data allow, and zero above.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from tsd_casadi.encoding.harmonics import Harmonics
from tsd_casadi.learning.loop_response import LoopResponse
from tsd_casadi.state import Vector

LARGEST_CONTRACTION = 0.9
# standard deviations of gain and delay that the choice has to survive
CAUTION = 2.0


@dataclass(frozen=True)
class LearningFilter:
    """L and Q for the harmonics 0 ... N of one motion.

    Attributes:
        response: What it was designed for.
        L: Complex gains on the feedback, (N + 1,).
        Q: 1 where something is learned, else 0, (N + 1,).
        lead: l [s].
        bandwidth: Frequency of the highest learned harmonic [Hz].
        contraction: Predicted rho_n, (N + 1,).
        worst_contraction: The largest within the caution, (N + 1,).
        plain_contraction: |1 - T|, what the plain sum would have, (N + 1,).
    """

    response: LoopResponse
    L: Harmonics
    Q: Vector
    lead: float
    bandwidth: float
    contraction: Vector
    worst_contraction: Vector
    plain_contraction: Vector

    def apply(self, feedforward: Harmonics, feedback: Harmonics) -> Harmonics:
        """Compute the next feedforward.

        Args:
            feedforward: u_i, (N + 1,) [m/s^2].
            feedback: C e_i, (N + 1,) [m/s^2].

        Returns:
            (N + 1,) [m/s^2].
        """
        return np.asarray(self.Q * (feedforward + self.L * feedback))


def design_filter(response: LoopResponse, omega: Vector, P: float, D: float) -> LearningFilter:
    """Choose lead and bandwidth for an estimated response.

    Args:
        omega: Angular frequency of each harmonic, (N + 1,) [rad/s].
        P: Stiffness, positive [1/s^2].
        D: Damping [1/s].

    Returns:
        The filter.
    """
    lead = response.delay
    C = P + omega.astype(np.complex128) * 1j * D
    L = 1 - omega**2 / C * np.exp(1j * omega * lead) / response.gain
    nominal = np.abs(1 - L * response.transfer(omega, P, D))
    worst = np.max(
        [
            np.abs(1 - L * possible.transfer(omega, P, D))
            for possible in _possible_responses(response)
        ],
        axis=0,
    )
    too_large = np.flatnonzero(worst >= LARGEST_CONTRACTION)
    count = int(too_large[0]) if len(too_large) else len(omega)
    count = max(count, 1)  # the mean is always learned
    Q = (np.arange(len(omega)) < count).astype(float)
    return LearningFilter(
        response=response,
        L=L,
        Q=Q,
        lead=lead,
        bandwidth=float(omega[count - 1] / (2 * np.pi)),
        contraction=Q * nominal,
        worst_contraction=Q * worst,
        plain_contraction=np.abs(1 - response.transfer(omega, P, D)),
    )


def _possible_responses(response: LoopResponse) -> list[LoopResponse]:
    corners = product((-CAUTION, 0.0, CAUTION), repeat=2)
    return [
        LoopResponse(
            max(response.gain + a * response.gain_deviation, 0.1),
            response.delay + b * response.delay_deviation,
        )
        for a, b in corners
    ]
