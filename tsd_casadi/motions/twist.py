r"""The upper body turns about the vertical axis, to and fro.

.. math:: r_{z,ref} = s(t) A \sin \phi
"""

from __future__ import annotations

from dataclasses import dataclass

from tsd_casadi.motions.motion import Motion, Offset
from tsd_casadi.motions.parameter import parameter
from tsd_casadi.motions.sinusoid import sinusoid
from tsd_casadi.robot.robot import Robot


@dataclass(frozen=True)
class Twist(Motion):
    """A frame, by default the torso, about the world's z axis.

    Attributes:
        amplitude: A, half of peak to peak [rad].
        frequency: Laps per second [Hz].
    """

    amplitude: float = parameter(
        "rad", "half of peak to peak", low=0.0, high=3.0, extent=True, usual=0.1
    )
    frequency: float = parameter("Hz", "laps per second", default=0.25, low=0.01)

    name = "twist"

    def axes(self, robot: Robot) -> tuple[str, ...]:
        """Name the frame's rotation about z."""
        return (robot.axis_for(self.name, "frame", "rz", prefer="torso"),)

    def offset(self, phase: float) -> Offset:
        """Compute A sin phi."""
        return sinusoid(self.amplitude, phase)
