"""What every periodic motion offers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State


@dataclass(frozen=True)
class Reference:
    """Reference along one axis, relative to the middle of the motion.

    Attributes:
        x: Offset from the middle [m].
        xd: [m/s].
        xdd: [m/s^2].
    """

    x: float
    xd: float
    xdd: float


class Motion(Protocol):
    """A periodic reference along one axis of one task."""

    @property
    def name(self) -> str:
        """Name of the motion, a word of the command line and of queries."""

    @property
    def axis(self) -> str:
        """Axis of the task that moves."""

    @property
    def frequency(self) -> float:
        """Laps per second [Hz]."""

    @property
    def start_phase(self) -> float:
        """Phase at which the first lap starts [rad]."""

    @property
    def parameters(self) -> dict[str, float]:
        """What tells this motion from its variations, by name, SI units."""

    def task(self, robot: Robot) -> str:
        """Name the robot's task that carries the motion."""

    def middle(self, robot: Robot) -> State:
        """Compute the posture that the motion is about, at rest."""

    def check(self, robot: Robot) -> None:
        """Refuse what this robot cannot do.

        Raises:
            InvalidValue: If a parameter is out of the robot's range.
        """

    def reference(self, elapsed: float) -> Reference:
        """Compute the reference after some phase since the start [rad]."""
