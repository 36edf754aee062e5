r"""Vertical sinusoidal squat of the centre of mass.

.. math:: z_{ref} = z_{home} + h + s(t) A \sin \phi

The phase starts at pi, so that the first motion is down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tsd_casadi.motions.motion import Motion, Offset
from tsd_casadi.motions.parameter import parameter
from tsd_casadi.motions.sinusoid import sinusoid
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.standing import stand
from tsd_casadi.state import State


@dataclass(frozen=True)
class Squat(Motion):
    """A squat.

    Attributes:
        amplitude: A, half of peak to peak [m].
        frequency: Laps per second [Hz].
        height: h, middle of the motion above home [m].
    """

    amplitude: float = parameter("m", "half of peak to peak", low=0.0, extent=True, usual=0.03)
    frequency: float = parameter("Hz", "laps per second", default=0.25, low=0.01)
    height: float = parameter("m", "middle of the motion above home", default=0.0, place=True)

    name = "squat"
    start_phase = math.pi

    def axes(self, robot: Robot) -> tuple[str, ...]:
        """Name the vertical axis of the centre of mass."""
        return (robot.axis_for(self.name, "com", "z"),)

    def middle(self, robot: Robot) -> State:
        """Compute the posture in the middle of the motion, at rest."""
        return stand(robot, self.height)

    def offset(self, phase: float) -> Offset:
        """Compute A sin phi."""
        return sinusoid(self.amplitude, phase)
