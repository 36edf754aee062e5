"""No torque at all."""

from __future__ import annotations

import numpy as np

from tsd_casadi.state import State, Vector


class NoTorque:
    """Lets go: for robots on a stand, or whose drives brake by themselves."""

    def __init__(self, n: int) -> None:
        """Prepare for n joints."""
        self._tau = np.zeros(n)

    def watch(self, tau: Vector) -> None:
        """Note nothing."""

    def latch(self, state: State) -> None:
        """Note nothing."""

    def torque(self, state: State) -> Vector:
        """Give zero, (n,) [N m]."""
        return self._tau
