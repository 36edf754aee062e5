"""Whatever is measured and takes torques: a simulated robot, or a real one."""

from __future__ import annotations

from typing import Protocol

from tsd_casadi.state import State, Vector


class Plant(Protocol):
    """A robot during one repetition, one control period at a time."""

    @property
    def period(self) -> float:
        """Control period [s]."""

    @property
    def com(self) -> Vector:
        """True centre of mass of the last measurement, (3,) [m], world frame."""

    def measure(self) -> tuple[State, State]:
        """Measure the state now.

        Returns:
            The true state, and the one that the sensors tell.
        """

    def step(self, tau: Vector, time: float) -> None:
        """Apply a torque for one control period.

        Args:
            tau: Commanded, (n,) [N m].
            time: Since the repetition began [s].
        """
