"""References of named axes, written into a command tick by tick."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import pinocchio

from tsd_casadi.repetition.rotation import angular_motion, multiply, quaternion_of
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import COM_AXES, FRAME_AXES
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
        """Take what the command holds now for the middle, and track the tasks that move.

        Raises:
            UnknownField: If no task has one of the axes.
        """
        self.axes = tuple(axes)
        pairs = [_split(axis) for axis in axes]
        self.index = _indices(tick_format.axis_index(*pair) for pair in pairs)
        self._request, place = command.request, _Places(tick_format)
        for task in dict.fromkeys(task for task, _ in pairs):
            command[f"{task}.active"] = 1.0
        # translations of all tasks are written at once, one index each
        self._linear = _indices(i for i, (_, name) in enumerate(pairs) if name in COM_AXES)
        linear = [pairs[i] for i in self._linear]
        self._x = _indices(place.position(*pair) for pair in linear)
        self._xd = _indices(place.component("reference_velocity", *pair) for pair in linear)
        self._xdd = _indices(place.component("reference_acceleration", *pair) for pair in linear)
        self._u = _indices(place.component("feedforward", *pair) for pair in pairs)
        self._middle = self._request[self._x]
        kinds = {part.name: part for part in robot.description.tasks}
        self._coms = [
            _CenterOfMass(self._request, place, name)
            for name, part in kinds.items()
            if part.type == "com"
        ]
        self._shifted = False
        self._turns = [
            _Turn(self._request, place, task, pairs)
            for task in dict.fromkeys(task for task, name in pairs if name not in COM_AXES)
        ]
        self._model, self._data = robot.model, robot.model.createData()
        tracked = [(i, task, FRAME_AXES.index(name)) for i, (task, name) in enumerate(pairs)]
        com = [(i, task, way) for i, task, way in tracked if kinds[task].type == "com"]
        self._com_places = _indices(i for i, _, _ in com)
        self._com_ways = _indices(way for _, _, way in com)
        self._com_x = _indices(place.position(task, FRAME_AXES[way]) for _, task, way in com)
        self._frames = [
            (
                robot.frame_id(task),
                place.field("reference", task),
                _indices(i for i, owner, _ in tracked if owner == task),
                _indices(way for _, owner, way in tracked if owner == task),
            )
            for task, part in kinds.items()
            if part.type == "frame" and any(owner == task for owner, _ in pairs)
        ]

    def write(self, x: Vector, xd: Vector, xdd: Vector, feedforward: Vector) -> None:
        """Set all axes.

        Args:
            x: Offsets from the middle, (k,) [m, rad].
            xd: Their rates, (k,) [m/s, rad/s].
            xdd: Their second derivatives, (k,) [m/s^2, rad/s^2].
            feedforward: Learned term, (k,) [m/s^2, rad/s^2].
        """
        request, linear = self._request, self._linear
        if self._shifted:
            for com in self._coms:
                com.restore()
            self._shifted = False
        request[self._x] = self._middle + x[linear]
        request[self._xd] = xd[linear]
        request[self._xdd] = xdd[linear]
        request[self._u] = feedforward
        for turn in self._turns:
            turn.write(x, xd, xdd)

    def shift(self, offset: Vector, rate: Vector) -> None:
        """Move the references of the centre of mass until the next ``write``.

        Args:
            offset: (3,) [m], world axes.
            rate: (3,) [m/s].
        """
        self._shifted = True
        for com in self._coms:
            com.shift(offset, rate)

    def errors(self, state: State, com: Vector) -> Vector:
        """Compute what a robot in a known state is off the references, (k,) [m, rad].

        Args:
            com: Its centre of mass, (3,) [m], world frame.
        """
        found = np.empty(len(self.axes))
        found[self._com_places] = self._request[self._com_x] - com[self._com_ways]
        if self._frames:
            pinocchio.forwardKinematics(self._model, self._data, state.q)
        for frame, reference, places, ways in self._frames:
            placement = pinocchio.updateFramePlacement(self._model, self._data, frame)
            wanted = self._request[reference]
            R = pinocchio.Quaternion(wanted[3:]).matrix()
            turn = pinocchio.log3(R @ placement.rotation.T)
            found[places] = np.concatenate((wanted[:3] - placement.translation, turn))[ways]
        return found


class _Places:
    """Where fields and components of tasks are in a request."""

    def __init__(self, tick_format: TickFormat) -> None:
        self._format = tick_format

    def field(self, field: str, task: str) -> slice:
        return self._format.request.slice(f"{task}.{field}")

    def position(self, task: str, axis: str) -> int:
        """Where the reference of a translation is; all three have one."""
        return int(self.field("reference", task).start) + FRAME_AXES.index(axis)

    def component(self, field: str, task: str, axis: str) -> int:
        """Where one of the controlled axes is in a field of its task."""
        return int(self.field(field, task).start) + self._format.component_index(task, axis)

    def controlled(self, task: str) -> list[str]:
        """Axes that the task controls."""
        return [axis for owner, axis in self._format.axes if owner == task]


class _CenterOfMass:
    """A task of the centre of mass, to be shifted."""

    def __init__(self, request: Vector, place: _Places, task: str) -> None:
        # views
        self._x = request[place.field("reference", task)]
        self._xd = request[place.field("reference_velocity", task)]
        self._middle, self._rest = self._x.copy(), self._xd.copy()
        self._controlled = _indices(COM_AXES.index(axis) for axis in place.controlled(task))

    def shift(self, offset: Vector, rate: Vector) -> None:
        self._x += offset
        self._xd += rate[self._controlled]

    def restore(self) -> None:
        self._x[:], self._xd[:] = self._middle, self._rest


class _Turn:
    """The rotations of one task."""

    def __init__(
        self, request: Vector, place: _Places, task: str, pairs: Sequence[tuple[str, str]]
    ) -> None:
        names = FRAME_AXES[3:]
        turning = [
            (i, names.index(name))
            for i, (owner, name) in enumerate(pairs)
            if owner == task and name in names
        ]
        self._places = _indices(i for i, _ in turning)
        self._ways = _indices(way for _, way in turning)
        # a turn about one axis and another one moves the third as well
        controlled = [name for name in place.controlled(task) if name in names]
        self._controlled = _indices(names.index(name) for name in controlled)
        self._request = request
        self._omega, self._alpha = (
            _indices(place.component(field, task, name) for name in controlled)
            for field in ("reference_velocity", "reference_acceleration")
        )
        self._orientation = request[place.field("reference", task)][3:]
        self._middle = self._orientation.copy()

    def write(self, x: Vector, xd: Vector, xdd: Vector) -> None:
        motion = np.zeros((3, 3))  # rotation vector, its rate, its second derivative
        motion[:, self._ways] = x[self._places], xd[self._places], xdd[self._places]
        self._orientation[:] = multiply(quaternion_of(motion[0]), self._middle)
        omega, alpha = angular_motion(*motion)
        self._request[self._omega] = omega[self._controlled]
        self._request[self._alpha] = alpha[self._controlled]


def _split(axis: str) -> tuple[str, str]:
    task, _, name = axis.rpartition(".")
    return task, name


def _indices(values: Iterable[int]) -> Vector:
    return np.array(list(values), dtype=int)
