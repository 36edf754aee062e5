"""Contact forces as arrows: from where each one acts, along it, as long as it is strong."""

from __future__ import annotations

import numpy as np

from tsd_casadi.robot.foot import Point
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, Vector

# the robot's whole weight is as long as its centre of mass is high at home
LEAST_PRESSURE = 1e-3  # of the weight: what presses less has no centre of pressure


def force_arrows(robot: Robot, q: Vector, wrenches: Vector) -> Matrix:
    """Compute the arrows of the contact forces.

    Args:
        q: Configuration, (nq,).
        wrenches: [force; moment] of each contact [N, N m], (6 c,), as a tick tells them:
            soles in their own axes, points in the world's.

    Returns:
        (c, 2, 3) [m], world frame: foot and tip of each arrow; a sole's begins at its
        centre of pressure.
    """
    scale = float(robot.home_com[2]) / robot.weight
    arrows = np.empty((len(robot.feet), 2, 3))
    contacts = zip(robot.feet, robot.sole_placements(q), wrenches.reshape(-1, 6), strict=True)
    for arrow, (foot, place, wrench) in zip(arrows, contacts, strict=True):
        force, moment = wrench[:3], wrench[3:]
        start = np.zeros(3)
        if not isinstance(foot, Point):
            if force[2] > LEAST_PRESSURE * robot.weight:
                start = np.array([-moment[1], moment[0], 0.0]) / force[2]
            force = place.rotation @ force
        arrow[0] = place.act(start)
        arrow[1] = arrow[0] + scale * force
    return arrows
