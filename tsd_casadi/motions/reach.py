r"""A frame on a straight line, to and fro.

.. math::

    x_{ref} = x_{middle} + s(t) A \sin \phi \; d, \qquad
    d = (\cos \alpha \cos \beta, \; \sin \alpha \cos \beta, \; \sin \beta)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.motion import Motion, Offset
from tsd_casadi.motions.parameter import parameter
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector


@dataclass(frozen=True)
class Reach(Motion):
    """A frame with a task of its position, by default a hand, on a straight line.

    Attributes:
        amplitude: A, half of peak to peak [m].
        frequency: Laps per second [Hz].
        direction: alpha, of the line from the world's x axis to y [rad].
        elevation: beta, of the line above the ground plane [rad].
    """

    amplitude: float = parameter("m", "half of peak to peak", low=0.0, extent=True, usual=0.03)
    frequency: float = parameter("Hz", "laps per second", default=0.25, low=0.01)
    direction: float = parameter(
        "rad", "of the line, from forwards to the left", default=0.0, low=-math.pi, high=math.pi
    )
    elevation: float = parameter(
        "rad", "of the line, above the ground", default=0.0, low=-math.pi / 2, high=math.pi / 2
    )

    name = "reach"

    def axes(self, robot: Robot) -> tuple[str, ...]:
        """Name the three translations of one frame.

        Raises:
            InvalidValue: If no task has all three.
        """
        tasks = robot.description.tasks
        able = [part.name for part in tasks if part.type == "frame" and {*"xyz"} <= {*part.axes}]
        described = robot.description.motions.get(self.name)
        task = described.task if described is not None else None
        if task is None and able:
            task = next((name for name in able if "hand" in name), able[0])
        if task is None or task not in able:
            known = ", ".join(f"{part.name} ({' '.join(part.axes)})" for part in tasks)
            raise InvalidValue(
                "the task of reach",
                str(task).lower(),
                f"a frame task of {robot.name} with the axes x, y and z; there is {known}. Add one "
                "to the robot file",
            )
        return tuple(f"{task}.{axis}" for axis in "xyz")

    def offset(self, phase: float) -> Offset:
        """Compute A sin phi along the line."""
        x = self.amplitude * self._line()
        sine, cosine = math.sin(phase), math.cos(phase)
        return Offset(x * sine, x * cosine, -x * sine)

    def _line(self) -> Vector:
        level = math.cos(self.elevation)
        return np.array(
            [
                math.cos(self.direction) * level,
                math.sin(self.direction) * level,
                math.sin(self.elevation),
            ]
        )
