r"""The ghost of a robot: the posture in which its tasks would be at their references.

Levenberg-Marquardt steps (Nocedal and Wright's book, section 10.3) from the
robot's own posture,

.. math:: \Delta q = J^T (J J^T + \mu I)^{-1} e(q)

on the errors of the soles, which stay, and of the controlled axes. Each step is the
shortest one, so that what no task controls stays as it is.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
import pinocchio

from tsd_casadi.robot.residuals import feet_residuals, task_place, task_residual
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_tasks import AngularMomentumFile, ComTaskFile, FrameTaskFile
from tsd_casadi.state import Vector

# mu: small beside the squares of a leg's lever arms (0.1 m^2), so that a step leaves
# 1e-5 of an error; large enough for straight knees and contacts that follow from each other
DAMPING = 1e-6
STEPS = 20
# of the errors: far below what a picture shows and a log tells [m, rad]
TOLERANCE = 1e-8
# farther goes no step, where a reference is out of reach [m, rad]
LONGEST_STEP = 0.2


def error_axes(robot: Robot) -> tuple[str, ...]:
    """Name the axes 'task.axis' in the order of a tick's errors."""
    kinds = (ComTaskFile, FrameTaskFile, AngularMomentumFile)
    return tuple(
        f"{task.name}.{axis}"
        for task in robot.description.all_tasks
        if isinstance(task, kinds)
        for axis in task.axes
    )


def ghost_posture(
    robot: Robot, q: Vector, errors: Mapping[str, float], moved: Collection[str] = ()
) -> Vector:
    """Find the posture in which tasks are at their references, the feet where they are.

    Args:
        q: The robot's configuration, (nq,).
        errors: Reference - place there by 'task.axis' [m, rad], world axes, as a tick
            tells them.
        moved: Axes 'task.axis' of the motion: their tasks count although they are
            inactive in the robot file.

    Returns:
        (nq,); where a reference is out of reach, as near as the steps come.
    """
    model, data = robot.model, robot.model.createData()
    owners = {axis.rpartition(".")[0] for axis in moved}
    tasks = [
        task
        for task in robot.description.tasks
        if isinstance(task, ComTaskFile) or task.active or task.name in owners
    ]
    feet = robot.sole_placements(q)
    places = [task_place(robot, data, task, q) for task in tasks]
    ghost = q.copy()
    for _ in range(STEPS):
        residuals, jacobians = feet_residuals(robot, data, ghost, feet)
        for task, place in zip(tasks, places, strict=True):
            residual, jacobian = task_residual(robot, data, ghost, task, place, errors)
            residuals.append(residual)
            jacobians.append(jacobian)
        e, J = np.concatenate(residuals), np.vstack(jacobians)
        if np.abs(e).max() < TOLERANCE:
            break
        step = J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(len(J)), e)
        step *= min(1.0, LONGEST_STEP / max(np.abs(step).max(), LONGEST_STEP))
        ghost = pinocchio.integrate(model, ghost, step)
    return np.asarray(ghost)
