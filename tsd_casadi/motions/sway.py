r"""Sideways sinusoidal sway of the centre of mass.

.. math:: y_{ref} = y_{home} + s(t) A \sin \phi
"""

from __future__ import annotations

from dataclasses import dataclass

from tsd_casadi.motions.motion import Motion, Offset
from tsd_casadi.motions.parameter import parameter
from tsd_casadi.motions.sinusoid import sinusoid
from tsd_casadi.robot.robot import Robot


@dataclass(frozen=True)
class Sway(Motion):
    """The centre of mass, left and right.

    Attributes:
        amplitude: A, half of peak to peak [m].
        frequency: Laps per second [Hz].
    """

    amplitude: float = parameter("m", "half of peak to peak", low=0.0, extent=True, usual=0.03)
    frequency: float = parameter("Hz", "laps per second", default=0.25, low=0.01)

    name = "sway"

    def axes(self, robot: Robot) -> tuple[str, ...]:
        """Name one horizontal axis of the centre of mass."""
        return (robot.axis_for(self.name, "com", "y"),)

    def offset(self, phase: float) -> Offset:
        """Compute A sin phi."""
        return sinusoid(self.amplitude, phase)
