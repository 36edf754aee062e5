r"""The last torque, less of it from period to period."""

from __future__ import annotations

import math

import numpy as np

from tsd_casadi.state import State, Vector


class DecayingTorque:
    r"""Goes from the last torque to none: :math:`\tau(t) = \tau_0 e^{-t / T}`.

    It takes no state into account: for robots that are hung up or that fall softly.
    """

    def __init__(self, n: int, time: float, period: float) -> None:
        """Prepare for n joints.

        Args:
            time: T, after which 37 % are left [s].
            period: Control period [s].
        """
        self._share = math.exp(-period / time)
        self._tau = np.zeros(n)

    def watch(self, tau: Vector) -> None:
        """Note what is applied."""
        self._tau = tau

    def latch(self, state: State) -> None:
        """Go on from what was applied last, or from nothing."""

    def torque(self, state: State) -> Vector:
        """Compute the next torque, (n,) [N m]; the first one is a period old already."""
        self._tau = self._share * self._tau
        return self._tau
