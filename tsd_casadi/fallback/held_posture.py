r"""The posture in which the answers stopped, held against gravity.

.. math::

    \tau = \mathrm{clip}\left(\tau_g(q) + P (q_{latch} - q_a) - D \dot q_a, \; \pm\tau_{max}\right)

Gravity compensation alone lets a robot sink whose model is wrong; the stiffness
about the latched posture carries what the model lacks, and damping takes out the
speed of the motion.
"""

from __future__ import annotations

import numpy as np

from tsd_casadi.fallback.gravity_torque import GravityTorque
from tsd_casadi.fallback.hold_gains import hold_gains
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector


class HeldPosture:
    """Gravity compensation, and joint stiffness about the latched posture."""

    def __init__(self, robot: Robot, P: float | None = None, D: float | None = None) -> None:
        """Prepare for one robot.

        Args:
            P: Stiffness of every joint [N m/rad, N/m]; see ``hold_gains``.
            D: Damping of every joint [N m s/rad, N s/m]; the same.
        """
        usual_P, usual_D = hold_gains(robot)
        self.P = usual_P if P is None else np.full(robot.n, P)
        self.D = usual_D if D is None else np.full(robot.n, D)
        self._gravity = GravityTorque(robot)
        self._limit = robot.torque_limit
        self._posture: Vector = robot.home.q[7:]

    def watch(self, tau: Vector) -> None:
        """Note nothing."""

    def latch(self, state: State) -> None:
        """Note the posture."""
        self._posture = state.q[7:].copy()

    def torque(self, state: State) -> Vector:
        """Compute the torque that brings the joints back to the posture, (n,) [N m]."""
        q, v = state.q, state.v
        tau = self._gravity(q) + self.P * (self._posture - q[7:]) - self.D * v[6:]
        return np.clip(tau, -self._limit, self._limit)
