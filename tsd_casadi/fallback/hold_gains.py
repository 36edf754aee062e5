"""Gains of a hold from a robot's weight, height and inertias, where its file names none."""

from __future__ import annotations

import math

import numpy as np
import pinocchio

from tsd_casadi.fallback.contact_jacobian import contact_jacobian
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector

# Of m g h, the torque per angle with which gravity tips a robot over about its
# ankles: a leg bends under masses that are 10 % off by a height that goes with h over
# this. One ankle of two has to bring up half of it to stand at all; with 2 a moving
# squat of an adult humanoid ends 5.6 mm from where the answers stopped, with 3 3 mm, and
# with 4 it swings itself over where motors lag by 10 ms.
STIFFNESS = 3.0
# The same of m g / h where a joint slides and takes the whole weight.
SLIDING_STIFFNESS = 10.0
# D / P over sqrt(h / g), the time in which the robot would fall. Half as much swings
# over where motors lag by 10 ms, twice as much is chatter at the longest control
# period, 5 ms.
DAMPING_TIME = 0.027
# What carries no weight need not be stiffer than this lets it swing [rad/s]: an arm or
# a wrist at the stiffness of a leg is chatter. A fortieth of a second is slow against
# control periods and motors' lags, and fast against a fall.
FREQUENCY = 40.0
# of the critical damping of such a joint
DAMPING_RATIO = 0.7


def hold_gains(robot: Robot) -> tuple[Vector, Vector]:
    """Compute the gains that a robot asks for.

    Returns:
        P (n,) [N m/rad] and D (n,) [N m s/rad], [N/m] and [N s/m] of a joint that
        slides: at most 3 m g h (10 m g / h) and what goes with that, less of a light
        joint that bears no weight.
    """
    height = float(robot.home_com[2])
    gravity = float(np.linalg.norm(robot.model.gravity.linear))
    slides = ["P" in joint.shortname()[len("JointModel") :] for joint in robot.model.joints[2:]]
    share = np.where(slides, SLIDING_STIFFNESS / height, STIFFNESS * height)
    stiffest = robot.weight * share
    damping = DAMPING_TIME * math.sqrt(height / gravity) * stiffest
    inertia = standing_inertia(robot)
    return (
        np.minimum(stiffest, FREQUENCY**2 * inertia),
        np.minimum(damping, 2 * DAMPING_RATIO * FREQUENCY * inertia),
    )


def standing_inertia(robot: Robot) -> Vector:
    r"""Compute what a torque of each joint has to move at home while the contacts hold.

    .. math::

        1 / \left(M^{-1} - M^{-1} J_c^T (J_c M^{-1} J_c^T)^{+} J_c M^{-1}\right)_{jj}

    Returns:
        (n,) [kg m^2, kg].
    """
    model, q = robot.model, robot.home.q
    data = model.createData()
    upper = np.triu(pinocchio.crba(model, data, q))
    M_inv = np.linalg.inv(upper + np.triu(upper, 1).T)
    J = contact_jacobian(robot, data, q)
    held = M_inv @ J.T
    free = np.diag(M_inv - held @ np.linalg.pinv(J @ held, rcond=1e-9) @ held.T)[6:]
    # what the contacts hold altogether can take any stiffness
    return np.asarray(1 / np.maximum(free, 1e-9))
