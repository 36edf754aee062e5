"""Whatever is measured and takes torques: a simulated robot, or a real one."""

from __future__ import annotations

import abc
from dataclasses import dataclass
from typing import Any

from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector


@dataclass(frozen=True)
class Truth:
    """What a simulation knows and a robot does not.

    Attributes:
        state: The true state.
        com: The true centre of mass, (3,) [m], world frame.
    """

    state: State
    com: Vector


class Plant(abc.ABC):
    """A robot, one control period at a time.

    Attributes:
        robot: The robot as its files describe it, which is what the controller
            believes.
        period: Control period [s].
        position_time: When the positions that ``measure`` tells belong to,
            seconds after the instant at which it is called.
        velocity_time: The same of the velocities. References are evaluated at
            these two times.
    """

    robot: Robot
    period: float = 1e-3
    position_time: float = 0.0
    velocity_time: float = 0.0

    def start(self, posture: State, seed: int = 0) -> None:  # noqa: B027
        """Bring the robot to rest in a posture before a repetition begins.

        Args:
            posture: Soles flat, joints as the motion's middle.
            seed: Of whatever is random about it.
        """

    @abc.abstractmethod
    def measure(self) -> State:
        """Read the state as the sensors tell it now."""

    @abc.abstractmethod
    def apply(self, tau: Vector) -> None:
        """Apply a torque for one control period.

        Args:
            tau: (n,) [N m].
        """

    def truth(self) -> Truth | None:
        """Tell the truth at the last measurement, where somebody knows it."""
        return None

    def settings(self) -> dict[str, Any]:
        """Describe the plant for the records, plain data."""
        return {}
