"""What feet and Cartesian tasks are off their places, in numbers, with the Jacobians by v."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import COM_AXES, FRAME_AXES
from tsd_casadi.robot.robot_file_tasks import ComTaskFile
from tsd_casadi.state import Matrix, Vector


def task_place(robot: Robot, data: Any, task: Any, q: Vector) -> Any:
    """Compute where a task is.

    Args:
        task: A Cartesian task of the robot file.

    Returns:
        The centre of mass, (3,) [m], or ``pinocchio.SE3`` of a frame; world frame.
    """
    if isinstance(task, ComTaskFile):
        return robot.center_of_mass(q)
    pinocchio.framesForwardKinematics(robot.model, data, q)
    return data.oMf[robot.frame_id(task.name)].copy()


def feet_residuals(
    robot: Robot, data: Any, q: Vector, places: list[Any]
) -> tuple[list[Vector], list[Matrix]]:
    """Compute what each foot is off its place, and the Jacobians of what it keeps.

    Args:
        places: ``pinocchio.SE3`` of each contact, world frame.
    """
    model = robot.model
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.framesForwardKinematics(model, data, q)
    errors, jacobians = [], []
    for foot, place in zip(robot.feet, places, strict=True):
        errors.append(foot.error(data, place))
        jacobians.append(foot.jacobian(model, data))
    return errors, jacobians


def task_residual(
    robot: Robot, data: Any, q: Vector, task: Any, place: Any, offsets: Mapping[str, float]
) -> tuple[Vector, Matrix]:
    """Compute what a task's controlled axes are off a place moved by offsets.

    Args:
        place: As of ``task_place``.
        offsets: By 'task.axis' [m, rad], world axes; zero where nothing is said.

    Returns:
        Error, (k,) [m, rad], and Jacobian, (k, nv), world axes.
    """
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
