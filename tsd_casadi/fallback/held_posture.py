r"""The posture in which the answers stopped, held against gravity.

.. math::

    \tau = \mathrm{clip}\left(\tau_g(q) + P (q_{latch} - q_a) - D \dot q_a, \; \pm\tau_{max}\right)

Gravity compensation alone lets a robot sink whose model is wrong; the stiffness
about the latched posture carries what the model lacks, and damping takes out the
speed of the motion.
"""

from __future__ import annotations

import math

import numpy as np

from tsd_casadi.fallback.gravity_torque import GravityTorque
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector

# Of m g h, the torque per angle with which gravity tips a robot over about its
# ankles: a leg bends under masses that are 10 % off by a height that goes with h over
# this. One ankle of two has to bring up half of it to stand at all; with 2 a moving
# squat of hermes_lower ends 5.6 mm from where the answers stopped, with 3 3 mm, and
# with 4 it swings itself over where motors lag by 10 ms.
STIFFNESS = 3.0
# The same of m g / h where a joint slides and takes the whole weight.
SLIDING_STIFFNESS = 10.0
# D / P over sqrt(h / g), the time in which the robot would fall. Half as much swings
# over where motors lag by 10 ms, twice as much is chatter at the longest control
# period, 5 ms.
DAMPING_TIME = 0.027


class HeldPosture:
    """Gravity compensation, and joint stiffness about the latched posture."""

    def __init__(self, robot: Robot, P: float | None = None, D: float | None = None) -> None:
        """Prepare for one robot.

        Args:
            P: Stiffness of every joint [N m/rad, N/m]; see ``usual_stiffness``.
            D: Damping of every joint [N m s/rad, N s/m]; see ``usual_damping``.
        """
        self.P = usual_stiffness(robot) if P is None else np.full(robot.n, P)
        self.D = usual_damping(robot, self.P) if D is None else np.full(robot.n, D)
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


def usual_stiffness(robot: Robot) -> Vector:
    """Compute the stiffness that a robot's weight and height ask for.

    Returns:
        (n,), 3 m g h of a joint that turns [N m/rad], 10 m g / h of one that
        slides [N/m].
    """
    height = float(robot.home_com[2])
    slides = ["P" in joint.shortname()[len("JointModel") :] for joint in robot.model.joints[2:]]
    share = np.where(slides, SLIDING_STIFFNESS / height, STIFFNESS * height)
    return np.asarray(robot.weight * share)


def usual_damping(robot: Robot, P: Vector) -> Vector:
    """Compute the damping that goes with a stiffness, (n,) [N m s/rad, N s/m]."""
    gravity = float(np.linalg.norm(robot.model.gravity.linear))
    return DAMPING_TIME * math.sqrt(float(robot.home_com[2]) / gravity) * P
