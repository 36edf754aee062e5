"""The tasks that a robot file asks for."""

from __future__ import annotations

from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_tasks import AngularMomentumFile, ComTaskFile, FrameTaskFile
from tsd_casadi.tasks.angular_momentum_task import AngularMomentumTask
from tsd_casadi.tasks.com_task import ComTask
from tsd_casadi.tasks.frame_task import FrameTask
from tsd_casadi.tasks.task import Task


def make_tasks(robot: Robot) -> list[Task]:
    """Make the tasks of accelerations that a robot's file asks for.

    Returns:
        One task per entry, in the file's order; those of forces are among the costs.
    """
    tasks: list[Task] = []
    for part in robot.description.all_tasks:
        if isinstance(part, ComTaskFile):
            tasks.append(ComTask(part.name, part.axes, part.P, part.D, part.W))
        elif isinstance(part, FrameTaskFile):
            frame = robot.frame_name(part.name)
            tasks.append(
                FrameTask(part.name, frame, part.axes, part.P, part.D, part.W, part.active)
            )
        elif isinstance(part, AngularMomentumFile):
            inertia = robot.home_inertia
            tasks.append(
                AngularMomentumTask(part.name, part.axes, part.D, part.W, inertia, part.active)
            )
    return tasks
