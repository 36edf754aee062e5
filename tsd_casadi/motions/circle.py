r"""The centre of mass on a horizontal circle.

.. math::

    x_{ref} = x_{home} + s(t) A \cos \phi, \qquad
    y_{ref} = y_{home} + s(t) A \sin \phi
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tsd_casadi.motions.motion import Motion, Offset
from tsd_casadi.motions.parameter import parameter
from tsd_casadi.motions.sinusoid import sinusoid
from tsd_casadi.robot.robot import Robot


@dataclass(frozen=True)
class Circle(Motion):
    """A circle about home, seen from above anticlockwise.

    Attributes:
        amplitude: A, its radius [m].
        frequency: Laps per second [Hz].
    """

    amplitude: float = parameter("m", "radius", low=0.0, extent=True, usual=0.02)
    frequency: float = parameter("Hz", "laps per second", default=0.25, low=0.01)

    name = "circle"

    def axes(self, robot: Robot) -> tuple[str, ...]:
        """Name both horizontal axes of the centre of mass."""
        return tuple(robot.axis_for(self.name, "com", axis) for axis in "xy")

    def offset(self, phase: float) -> Offset:
        """Compute A (cos phi, sin phi)."""
        return sinusoid(self.amplitude, phase, (math.pi / 2, 0.0))
