r"""Sways that make a robot's inertias observable while it squats.

A vertical squat never turns the trunk, so the heights of its centres of mass do
not show in any torque. Every orientation task is therefore turned about the
world's axes and the centre of mass moved sideways, each at its own harmonic of
the motion,

.. math:: w_{ref} = A_w (\sin 2 \phi, \sin \phi, \sin 3 \phi), \qquad
    \Delta x_{ref} = A_x (\cos 3 \phi, \cos 2 \phi, 0),

the orientations in turn with either sign, blended in over the first lap. For
fast motions the amplitudes are smaller, so that accelerations stay below a bound.
"""

from __future__ import annotations

import math

import numpy as np
import pinocchio

from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.robot.robot_file_sections import FRAME_AXES
from tsd_casadi.state import Vector

ANGLE = 0.08  # A_w [rad]
SHIFT = 0.01  # A_x [m]
TURNS = np.array([2.0, 1.0, 3.0])
SHIFTS = np.array([3.0, 2.0, 0.0])
FASTEST_TURN = 8.0  # rad/s^2
FASTEST_SHIFT = 1.0  # m/s^2


class Excitation(Compensator):
    """Adds sways to the references of frame tasks and to the centre of mass."""

    def start(self, setting: Setting) -> None:
        """Note which tasks turn."""
        self._dt = setting.period
        self._first: float | None = None
        self._last: float | None = None
        self._axes = {
            task.name: [FRAME_AXES.index(axis) for axis in task.axes]
            for task in setting.robot.description.tasks
            if task.type == "frame" and {"rx", "ry", "rz"} <= set(task.axes)
        }
        self._upright: dict[str, Vector] = {}

    def before(self, moment: Moment) -> None:
        """Write the references of this tick."""
        phase = moment.phase
        self._first = phase if self._first is None else self._first
        rate = 0.0 if self._last is None else (phase - self._last) / self._dt
        self._last = phase
        blend = min((phase - self._first) / (2 * math.pi), 1.0)
        angle = blend * _bounded(ANGLE, FASTEST_TURN, rate * TURNS)
        turn = angle * np.sin(TURNS * phase)
        turning = angle * rate * TURNS * np.cos(TURNS * phase)
        for index, (name, rows) in enumerate(self._axes.items()):
            sign = (-1) ** index
            reference = moment.command[f"{name}.reference"]
            upright = self._upright.setdefault(name, reference[3:].copy())
            R = pinocchio.exp3(sign * turn) @ pinocchio.Quaternion(upright).toRotationMatrix()
            reference[3:] = pinocchio.Quaternion(R).coeffs()
            velocity = np.concatenate((np.zeros(3), sign * turning))
            moment.command[f"{name}.reference_velocity"] = velocity[rows]
        sway = blend * _bounded(SHIFT, FASTEST_SHIFT, rate * SHIFTS) * (SHIFTS > 0)
        moment.shift = moment.shift + sway * np.cos(SHIFTS * phase)
        moment.shift_rate = moment.shift_rate - sway * rate * SHIFTS * np.sin(SHIFTS * phase)


def _bounded(amplitude: float, fastest: float, omega: Vector) -> Vector:
    """Choose amplitudes of sines whose second derivatives stay below a bound."""
    squared = np.maximum(omega**2, fastest / amplitude)
    return np.asarray(fastest / squared)
