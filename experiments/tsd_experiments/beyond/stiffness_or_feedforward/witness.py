"""What is noted of a simulated run beside its log."""

from __future__ import annotations

from typing import Any

import numpy as np

from tsd_casadi.state import Vector
from tsd_clients.simulator.disturbances import Disturbance
from tsd_clients.simulator.state_map import StateMap


class Witness(Disturbance):
    """Adds nothing; notes the centre of mass and what the ground carries.

    The constraint forces on the base's translation are all external ones, those
    of the ground, for joints' friction and limits act on joints only.
    """

    def __init__(self) -> None:
        """Start with nothing."""
        self.reset()

    def reset(self) -> None:
        """Forget the run before."""
        self._com: list[Vector] = []
        self._force: list[float] = []

    @property
    def com(self) -> Vector:
        """True centre of mass at each tick, (N, 3) [m], world frame."""
        return np.array(self._com)

    @property
    def force(self) -> Vector:
        """Norm of the ground's force during the step before each tick, (N,) [N]."""
        return np.array(self._force)

    def apply(self, data: Any, state_map: StateMap, time: float) -> None:
        """Note centre of mass and ground force."""
        self._com.append(data.subtree_com[state_map.base_body].copy())
        base = data.model.body_dofadr[state_map.base_body]
        self._force.append(float(np.linalg.norm(data.qfrc_constraint[base : base + 3])))
