r"""Standing higher or lower than home.

Newton steps from home solve e(q) = 0 and stay as near to home as that allows,

.. math::

    \Delta q = \alpha \, \delta + J^T (J J^T)^{-1} (e - \alpha J \delta), \qquad
    \delta = q_{home} \ominus q

where e stacks the soles' poses, the points' positions, the base's orientation and
the centre of mass, each against home, the centre of mass against home raised by a height.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, State, Vector

# alpha: larger steps overshoot where the knees are nearly straight
HOMING = 0.3
STEPS = 60
# more steps, alpha = 0, where home draws too slowly
LAST_STEPS = 5
TOLERANCE = 1e-9  # of the last step [m, rad]
# keeps J J^T invertible where a height is out of reach and J loses rank
DAMPING = 1e-12
# share of what can be reached: near the limits knees are straight or folded up
COMFORT = 0.45
RESOLUTION = 1e-3  # m


def stand(robot: Robot, height: float) -> State:
    """Find the posture with the centre of mass above home by a height, at rest.

    Args:
        height: Above home, negative below [m].

    Returns:
        Feet and base orientation as at home, the centre of mass straight
        above or below its place at home.

    Raises:
        InvalidValue: If the robot cannot stand like that.
    """
    if height == 0.0:
        return robot.home
    model, home = robot.model, robot.home.q
    data = model.createData()
    # far from the ground and NaN are refused before Newton can diverge
    if abs(height) < robot.home_com[2]:
        places = robot.sole_placements(home)
        com = robot.home_com + np.array([0.0, 0.0, height])
        q = home.copy()
        for alpha in [HOMING] * STEPS + [0.0] * LAST_STEPS:
            error, J = _residual(robot, data, q, places, com)
            gram = J @ J.T + DAMPING * np.eye(len(J))
            homeward = alpha * pinocchio.difference(model, q, home)
            step = homeward + J.T @ np.linalg.solve(gram, error - J @ homeward)
            q = pinocchio.integrate(model, q, step)
            if np.abs(step).max() < TOLERANCE:
                inside = (model.lowerPositionLimit <= q) & (q <= model.upperPositionLimit)
                if inside[7:].all():
                    return State(q, np.zeros(robot.nv))
                break
    raise InvalidValue(
        "height", f"{height:g} m", f"a height that {robot.name} can stand at, 0 is home"
    )


@cache
def standing_heights(robot: Robot) -> tuple[float, float]:
    """Find between which heights a robot stands comfortably, far from its joints' limits.

    Returns:
        ``COMFORT`` of the lowest and of the highest that it can stand at, above
        home, to 1 mm [m].
    """
    low, high = (COMFORT * _farthest(robot, sign) for sign in (-1.0, 1.0))
    return low, high


def _farthest(robot: Robot, sign: float) -> float:
    """Find the last height in one direction by halving."""
    reached, missed = 0.0, float(robot.home_com[2])
    while missed - reached > RESOLUTION:
        middle = 0.5 * (reached + missed)
        try:
            stand(robot, sign * middle)
        except InvalidValue:
            missed = middle
        else:
            reached = middle
    return sign * reached


def _residual(
    robot: Robot, data: Any, q: Vector, places: list[Any], com: Vector
) -> tuple[Vector, Matrix]:
    """Compute what is wrong with a configuration, and its Jacobian by v."""
    model = robot.model
    J_com = pinocchio.jacobianCenterOfMass(model, data, q)
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.framesForwardKinematics(model, data, q)
    errors: list[Vector] = []
    jacobians: list[Matrix] = []
    for foot, place in zip(robot.feet, places, strict=True):
        errors.append(foot.error(data, place))
        jacobians.append(foot.jacobian(model, data))
    rotation, upright = (pinocchio.Quaternion(x[3:7]).matrix() for x in (q, robot.home.q))
    errors.append(pinocchio.log3(rotation.T @ upright))
    jacobians.append(np.eye(3, robot.nv, k=3))
    errors.append(com - data.com[0])
    jacobians.append(J_com)
    return np.concatenate(errors), np.vstack(jacobians)
