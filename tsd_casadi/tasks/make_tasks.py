"""The tasks that a robot file asks for."""

from __future__ import annotations

from tsd_casadi.robot.robot import Robot
from tsd_casadi.tasks.com_task import ComTask
from tsd_casadi.tasks.frame_task import FrameTask
from tsd_casadi.tasks.task import Task


def make_tasks(robot: Robot) -> list[Task]:
    """Make the tasks that a robot's file asks for.

    Returns:
        One task per entry, in the file's order.
    """
    tasks: list[Task] = []
    for part in robot.description.tasks:
        if part.type == "com":
            tasks.append(ComTask(part.name, part.axes, part.P, part.D, part.W))
        else:
            frame = robot.frame_name(part.name)
            tasks.append(
                FrameTask(part.name, frame, part.axes, part.P, part.D, part.W, part.active)
            )
    return tasks
