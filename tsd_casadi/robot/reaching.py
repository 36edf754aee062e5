r"""The posture in which tasks are off their place at home by given offsets.

Newton steps from home, as in ``standing``, on the error of feet and tasks

.. math:: e(q) = \begin{pmatrix} \log(T_{sole}(q)^{-1} T_{sole}) \\
    p_{point} - p_{point}(q) \\ x_{home} + \Delta x - x(q) \end{pmatrix}

for every axis that some task of the robot controls, with :math:`\Delta x` zero
where nothing is said; tasks that only some motions have count where they are moved.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import COM_AXES, FRAME_AXES
from tsd_casadi.robot.robot_file_tasks import ComTaskFile
from tsd_casadi.robot.standing import DAMPING, HOMING, LAST_STEPS, STEPS, TOLERANCE
from tsd_casadi.state import Matrix, State, Vector


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
    places = [_place(robot, data, task, home) for task in tasks]
    q = home.copy()
    for alpha in [HOMING] * STEPS + [0.0] * LAST_STEPS:
        errors, jacobians = _feet(robot, data, q, feet)
        for task, place in zip(tasks, places, strict=True):
            error, J = _task(robot, data, q, task, place, offsets)
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


def _place(robot: Robot, data: Any, task: Any, q: Vector) -> Any:
    if isinstance(task, ComTaskFile):
        return robot.center_of_mass(q)
    pinocchio.framesForwardKinematics(robot.model, data, q)
    return data.oMf[robot.frame_id(task.name)].copy()


def _feet(
    robot: Robot, data: Any, q: Vector, places: list[Any]
) -> tuple[list[Vector], list[Matrix]]:
    model = robot.model
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.framesForwardKinematics(model, data, q)
    errors, jacobians = [], []
    for foot, place in zip(robot.feet, places, strict=True):
        errors.append(foot.error(data, place))
        jacobians.append(foot.jacobian(model, data))
    return errors, jacobians


def _task(
    robot: Robot, data: Any, q: Vector, task: Any, place: Any, offsets: Mapping[str, float]
) -> tuple[Vector, Matrix]:
    """Error and Jacobian of a task's controlled axes, world axes."""
    model = robot.model
    wanted = np.array([offsets.get(f"{task.name}.{axis}", 0.0) for axis in FRAME_AXES])
    if isinstance(task, ComTaskFile):
        rows = [COM_AXES.index(axis) for axis in task.axes]
        J = pinocchio.jacobianCenterOfMass(model, data, q)
        return (place + wanted[:3] - data.com[0])[rows], J[rows]
    frame = robot.frame_id(task.name)
    rows = [FRAME_AXES.index(axis) for axis in task.axes]
    pinocchio.framesForwardKinematics(model, data, q)
    now = data.oMf[frame]
    turned = pinocchio.exp3(wanted[3:]) @ place.rotation
    error = np.concatenate(
        (
            place.translation + wanted[:3] - now.translation,
            pinocchio.log3(turned @ now.rotation.T),
        )
    )
    J = pinocchio.computeFrameJacobian(model, data, q, frame, pinocchio.LOCAL_WORLD_ALIGNED)
    return error[rows], J[rows]
