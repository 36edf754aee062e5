r"""From posture to posture without a jerk.

All references go a share s of their way, with velocity and acceleration,

.. math:: s(x) = x - \frac{\sin 2 \pi x}{2 \pi}, \qquad x = t / T
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pinocchio

from tsd_casadi.motions.hold import hold
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import FRAME_AXES
from tsd_casadi.robot.robot_file_tasks import ComTaskFile
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.command import Command

# highest accelerations on the way: of the centre of mass [m/s^2], which shifts
# the centre of pressure by 0.08 s^2 times that, and of any joint [rad/s^2]
ACCELERATION, JOINT_ACCELERATION = 0.4, 4.0


def short_way(robot: Robot, postures: Sequence[State]) -> list[int]:
    """Order postures from home on, each time to the nearest one; tell their indices."""
    way, left, last = [], set(range(len(postures))), robot.home
    while left:
        durations = {index: duration_of(robot, last, postures[index]) for index in left}
        nearest = min(durations, key=durations.__getitem__)
        left.remove(nearest)
        way.append(nearest)
        last = postures[nearest]
    return way


def duration_of(robot: Robot, start: State, end: State) -> float:
    """Compute how long a move from rest to rest takes [s]."""
    # x'' is at most 2 pi / duration^2 of the whole way
    shift = np.linalg.norm(robot.center_of_mass(end.q) - robot.center_of_mass(start.q))
    turn = np.abs(end.q[7:] - start.q[7:]).max()
    longest = max(float(shift) / ACCELERATION, float(turn) / JOINT_ACCELERATION)
    return math.sqrt(2 * math.pi * longest)


class Way:
    """All references between two postures, with their derivatives."""

    def __init__(
        self, robot: Robot, command: Command, start: State, end: State, duration: float
    ) -> None:
        """Note the references of both ends.

        Args:
            command: What ``write`` changes.
            start: At rest.
            end: At rest.
            duration: Of the move [s].
        """
        self._command = command
        self._duration = duration
        self._tasks = robot.description.tasks
        self._names = ["posture.q_ref", *(f"{task.name}.reference" for task in self._tasks)]
        self._start, self._end = (self._references(robot, posture) for posture in (start, end))

    def _references(self, robot: Robot, posture: State) -> dict[str, Vector]:
        hold(self._command, robot, posture)
        return {name: self._command[name].copy() for name in self._names}

    def write(self, x: float) -> None:
        """Set every reference.

        Args:
            x: Share of the time, from 0 to 1.
        """
        s = x - math.sin(2 * math.pi * x) / (2 * math.pi)
        sd = (1 - math.cos(2 * math.pi * x)) / self._duration
        sdd = 2 * math.pi * math.sin(2 * math.pi * x) / self._duration**2
        command = self._command
        for name in self._names:
            command[name] = self._start[name] + s * (self._end[name] - self._start[name])
        for task in self._tasks:
            name = f"{task.name}.reference"
            start, end = self._start[name], self._end[name]
            moved = end[:3] - start[:3]
            if not isinstance(task, ComTaskFile):
                first, last = (pinocchio.Quaternion(place[3:]).matrix() for place in (start, end))
                turn = pinocchio.log3(first.T @ last)
                turned = pinocchio.Quaternion(first @ pinocchio.exp3(s * turn))
                command[name][3:] = turned.coeffs()
                moved = np.concatenate((moved, first @ turn))
            along = moved[[FRAME_AXES.index(axis) for axis in task.axes]]
            command[f"{name}_velocity"] = sd * along
            command[f"{name}_acceleration"] = sdd * along
