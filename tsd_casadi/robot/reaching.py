r"""The posture in which tasks are off their place at home by given offsets.

Newton steps from home, as in ``standing``, on the error of feet and tasks

.. math:: e(q) = \begin{pmatrix} \log(T_{sole}(q)^{-1} T_{sole}) \\
    p_{point} - p_{point}(q) \\ x_{home} + \Delta x - x(q) \end{pmatrix}

for every axis that some task of the robot controls, with :math:`\Delta x` zero
where nothing is said; tasks that only some motions have count where they are moved.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio

from tsd_casadi.robot.residuals import feet_residuals, task_place, task_residual
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_tasks import ComTaskFile
from tsd_casadi.robot.standing import DAMPING, HOMING, LAST_STEPS, STEPS, TOLERANCE
from tsd_casadi.state import State


def reach(robot: Robot, middle: State, offsets: Mapping[str, float]) -> State | None:
    """Find the posture with some axes off those of another posture.

    Args:
        middle: The other posture, feet on the ground.
        offsets: By 'task.axis' [m, rad], world axes.

    Returns:
        A posture at rest that keeps the feet where they are, or None if there
        is none inside the joints' limits.
    """
    model, data, home = robot.model, robot.model.createData(), middle.q
    feet = robot.sole_placements(home)
    moved = {axis.split(".")[0] for axis in offsets}
    tasks = [
        task
        for task in robot.description.tasks
        if isinstance(task, ComTaskFile) or task.active or task.name in moved
    ]
    places = [task_place(robot, data, task, home) for task in tasks]
    q = home.copy()
    for alpha in [HOMING] * STEPS + [0.0] * LAST_STEPS:
        errors, jacobians = feet_residuals(robot, data, q, feet)
        for task, place in zip(tasks, places, strict=True):
            error, J = task_residual(robot, data, q, task, place, offsets)
            errors.append(error)
            jacobians.append(J)
        error, J = np.concatenate(errors), np.vstack(jacobians)
        gram = J @ J.T + DAMPING * np.eye(len(J))
        homeward = alpha * pinocchio.difference(model, q, home)
        step = homeward + J.T @ np.linalg.solve(gram, error - J @ homeward)
        if not np.abs(step).max() < 1.0:
            return None  # out of reach: Newton runs away
        q = pinocchio.integrate(model, q, step)
        if np.abs(step).max() < TOLERANCE:
            inside = (model.lowerPositionLimit <= q) & (q <= model.upperPositionLimit)
            return State(q, np.zeros(robot.nv)) if inside[7:].all() else None
    return None
