"""What a feedforward contributes to the error, as far as the loop is linear."""

from __future__ import annotations

import numpy as np

from tsd_casadi.repetition.compensator import Setting
from tsd_casadi.state import Vector


class LoopAnswer:
    """Follows e_u'' + D e_u' + P e_u = u from rest.

    Attributes:
        x: e_u of each learned axis [m, rad].
    """

    def __init__(self, setting: Setting) -> None:
        """Start at rest."""
        self._period = setting.period
        self.x, self._rate = np.zeros((2, setting.learned))

    def follow(self, u: Vector, P: Vector, D: Vector) -> None:
        """Go on by one period.

        Args:
            u: The feedforward, (k,) [m/s^2, rad/s^2].
            P: Stiffness of each axis, (k,) [1/s^2].
            D: Damping of each axis, (k,) [1/s].
        """
        self._rate = self._rate + self._period * (u - D * self._rate - P * self.x)
        self.x = self.x + self._period * self._rate
