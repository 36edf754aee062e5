r"""Vertical sinusoidal squat of the centre of mass.

.. math:: z_{ref} = z_{home} + h + s(t) A \sin \phi

The phase starts at pi, so the first motion is down, and s rises from 0 to 1
over the first half lap with zero velocity and acceleration at both ends.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.likely_meant import likely_meant
from tsd_casadi.motions.motion import Reference
from tsd_casadi.motions.parameter import unit_of
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.standing import stand
from tsd_casadi.state import State


@dataclass(frozen=True)
class Squat:
    """A squat.

    Attributes:
        amplitude: A, half of peak to peak [m].
        frequency: Laps per second [Hz].
        height: h, middle of the motion above home [m].
    """

    amplitude: float
    frequency: float
    height: float = 0.0

    name = "squat"
    axis = "z"
    start_phase = math.pi

    @property
    def parameters(self) -> dict[str, float]:
        """Amplitude [m], frequency [Hz] and height [m]."""
        return {
            "amplitude": self.amplitude,
            "frequency": self.frequency,
            "height": self.height,
        }

    def task(self, robot: Robot) -> str:
        """Name the centre-of-mass task that the robot file says."""
        return robot.description.motions.squat.task

    def middle(self, robot: Robot) -> State:
        """Compute the posture in the middle of the motion, at rest."""
        return stand(robot, self.height)

    def check(self, robot: Robot) -> None:
        """Refuse what this robot cannot do.

        Raises:
            InvalidValue: If amplitude, frequency or height is out of its range.
        """
        ranges = robot.description.motions.squat
        for name, (low, high) in (
            ("amplitude", ranges.amplitude),
            ("frequency", ranges.frequency),
            ("height", ranges.height),
        ):
            value = self.parameters[name]
            if low <= value <= high:
                continue
            unit = unit_of(self.name, name)
            expected = f"{low:g} to {high:g} {unit} for {robot.name}"
            if unit == "m":
                expected += likely_meant(value, low, high)
            raise InvalidValue(name, f"{value:g}", expected)

    def reference(self, elapsed: float) -> Reference:
        """Compute the reference after some phase since the start.

        Args:
            elapsed: phi - pi [rad], at least 0.

        Returns:
            Offset from the middle of the motion [m] with its time derivatives.
        """
        omega = 2 * math.pi * self.frequency
        sine, cosine = -math.sin(elapsed), -math.cos(elapsed)
        s, sd, sdd = _smooth_step(elapsed / math.pi)
        # derivatives of s by time: its argument runs at omega / pi
        sd, sdd = sd * omega / math.pi, sdd * (omega / math.pi) ** 2
        return Reference(
            x=self.amplitude * s * sine,
            xd=self.amplitude * (sd * sine + s * omega * cosine),
            xdd=self.amplitude * (sdd * sine + 2 * sd * omega * cosine - s * omega**2 * sine),
        )


def _smooth_step(x: float) -> tuple[float, float, float]:
    """Compute the quintic from 0 to 1 on [0, 1] with its two derivatives."""
    if x >= 1:
        return 1.0, 0.0, 0.0
    return (
        x**3 * (10 - 15 * x + 6 * x**2),
        30 * x**2 * (1 - x) ** 2,
        60 * x * (1 - x) * (1 - 2 * x),
    )
