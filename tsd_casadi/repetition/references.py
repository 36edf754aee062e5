"""References of named axes, written into a command tick by tick."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.repetition.rotation import angular_motion, multiply, quaternion_of
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import FRAME_AXES
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.format import TickFormat


class References:
    """Axes 'task.axis' of one or several tasks, relative to the posture held by a command.

    Attributes:
        axes: The axes, k of them.
        index: Where they are in the errors and feedbacks of a tick, (k,).
    """

    def __init__(
        self, robot: Robot, tick_format: TickFormat, command: Command, axes: Sequence[str]
    ) -> None:
        """Take what the command holds now for the middle.

        Raises:
            UnknownField: If no task has one of the axes.
        """
        self.axes = tuple(axes)
        pairs = [_split(axis) for axis in axes]
        self.index = np.array([tick_format.axis_index(*pair) for pair in pairs], dtype=int)
        kinds = {part.name: part for part in robot.description.tasks}
        self._robot, self._data = robot, robot.model.createData()
        self._tasks = [
            _TaskReferences(
                task,
                kinds[task],
                command,
                [FRAME_AXES.index(name) for owner, name in tick_format.axes if owner == task],
                [
                    (place, FRAME_AXES.index(name))
                    for place, (t, name) in enumerate(pairs)
                    if t == task
                ],
            )
            for task in dict.fromkeys(task for task, _ in pairs)
        ]

    def write(self, x: Vector, xd: Vector, xdd: Vector, feedforward: Vector) -> None:
        """Set all axes.

        Args:
            x: Offsets from the middle, (k,) [m, rad].
            xd: Their rates, (k,) [m/s, rad/s].
            xdd: Their second derivatives, (k,) [m/s^2, rad/s^2].
            feedforward: Learned term, (k,) [m/s^2, rad/s^2].
        """
        for task in self._tasks:
            task.write(x, xd, xdd, feedforward)

    def shift(self, offset: Vector, rate: Vector) -> None:
        """Move the references of the centre of mass, after ``write``.

        Args:
            offset: (3,) [m], world axes.
            rate: (3,) [m/s].
        """
        for task in self._tasks:
            if task.frame is None:
                task.shift(offset, rate)

    def errors(self, state: State, com: Vector) -> Vector:
        """Compute what a robot in a known state is off the references, (k,) [m, rad].

        Args:
            state: The state.
            com: Its centre of mass, (3,) [m], world frame.
        """
        found = np.empty(len(self.axes))
        frames = [task for task in self._tasks if task.frame is not None]
        if frames:
            pinocchio.framesForwardKinematics(self._robot.model, self._data, state.q)
        for task in self._tasks:
            if task.frame is None:
                error = np.append(task.reference[:3] - com, np.zeros(3))
            else:
                placement = self._data.oMf[self._robot.model.getFrameId(task.frame)]
                R = pinocchio.Quaternion(task.reference[3:]).matrix()
                turn = pinocchio.log3(R @ placement.rotation.T)
                error = np.append(task.reference[:3] - placement.translation, turn)
            found[task.places] = error[task.directions]
        return found


class _TaskReferences:
    """The axes of one task."""

    def __init__(
        self,
        name: str,
        part: Any,
        command: Command,
        controlled: Sequence[int],
        axes: Sequence[tuple[int, int]],
    ) -> None:
        self.frame: str | None = getattr(part, "frame", None)
        # places among all axes, and directions among x y z rx ry rz
        self.places = np.array([place for place, _ in axes], dtype=int)
        self.directions = np.array([direction for _, direction in axes], dtype=int)
        self._controlled = np.array(controlled, dtype=int)
        order = [list(controlled).index(direction) for direction in self.directions]
        self._components = np.array(order, dtype=int)
        # views into the request vector
        self.reference = command[f"{name}.reference"]
        self._velocity = command[f"{name}.reference_velocity"]
        self._acceleration = command[f"{name}.reference_acceleration"]
        self._feedforward = command[f"{name}.feedforward"]
        self._middle = self.reference.copy()
        self._turns = bool((self.directions >= 3).any())

    def write(self, x: Vector, xd: Vector, xdd: Vector, feedforward: Vector) -> None:
        motion = np.zeros((3, 6))  # offset, rate, second derivative
        motion[:, self.directions] = x[self.places], xd[self.places], xdd[self.places]
        self.reference[:3] = self._middle[:3] + motion[0, :3]
        if self._turns:
            self.reference[3:] = multiply(quaternion_of(motion[0, 3:]), self._middle[3:])
            motion[1, 3:], motion[2, 3:] = angular_motion(*motion[:, 3:])
        self._velocity[:] = motion[1, self._controlled]
        self._acceleration[:] = motion[2, self._controlled]
        self._feedforward[self._components] = feedforward[self.places]

    def shift(self, offset: Vector, rate: Vector) -> None:
        self.reference[:3] += offset
        self._velocity[:] += rate[self._controlled]


def _split(axis: str) -> tuple[str, str]:
    task, _, name = axis.rpartition(".")
    return task, name
