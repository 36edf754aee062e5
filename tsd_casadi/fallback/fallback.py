"""What is applied while no torque is answered."""

from __future__ import annotations

from typing import Protocol

from tsd_casadi.fallback.decaying_torque import DecayingTorque
from tsd_casadi.fallback.held_posture import HeldPosture
from tsd_casadi.fallback.no_torque import NoTorque
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_fallback import DecayFile, HoldFile
from tsd_casadi.state import State, Vector


class Fallback(Protocol):
    """Gives the torque of a period that has no answer, without any network."""

    def watch(self, tau: Vector) -> None:
        """Take note of what is applied in a period that was answered, (n,) [N m]."""

    def latch(self, state: State) -> None:
        """Begin, in the first period without an answer.

        Args:
            state: As measured at its beginning.
        """

    def torque(self, state: State) -> Vector:
        """Compute the torque for one period.

        Args:
            state: As measured now.

        Returns:
            (n,) [N m], within the robot's limits.
        """


def fallback_of(robot: Robot, period: float) -> Fallback:
    """Make what a robot's file names under ``fallback``; a hold where it names nothing.

    Args:
        period: Control period [s].
    """
    section = robot.description.fallback
    if isinstance(section, HoldFile):
        return HeldPosture(robot, section.P, section.D)
    if isinstance(section, DecayFile):
        return DecayingTorque(robot.n, section.time, period)
    return NoTorque(robot.n)
