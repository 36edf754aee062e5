"""Standing still: a posture as references of every task."""

from __future__ import annotations

import numpy as np

from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_tasks import ComTaskFile
from tsd_casadi.state import State
from tsd_casadi.tick.command import Command


def hold(command: Command, robot: Robot, posture: State) -> None:
    """Write a posture into a command: every task's reference and the joints'."""
    for task in robot.description.tasks:
        if isinstance(task, ComTaskFile):
            command[f"{task.name}.reference"] = robot.center_of_mass(posture.q)
        else:
            position, quaternion = robot.frame_placement(robot.frame_name(task.name), posture.q)
            command[f"{task.name}.reference"] = np.concatenate((position, quaternion))
    command["posture.q_ref"] = posture.q[7:]
