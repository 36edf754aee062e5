"""What tells one entry from another."""

from __future__ import annotations

from dataclasses import dataclass

from tsd_casadi.learning.context import NOWHERE, Context


@dataclass(frozen=True)
class EntryKey:
    """A motion with its parameters and the learned axes, on one robot in one context.

    Attributes:
        robot: Name of the robot.
        motion: Name of the motion, for instance 'squat'.
        version: Version of the motion.
        axes: Names 'task.axis' of the learned axes.
        parameters: Of the motion, SI units, rounded to 1e-6.
        context: Body, formulation and correction.
    """

    robot: str
    motion: str
    version: str
    axes: tuple[str, ...]
    parameters: tuple[tuple[str, float], ...]
    context: Context = NOWHERE

    @classmethod
    def of(
        cls,
        robot: str,
        motion: str,
        version: str,
        axes: tuple[str, ...],
        parameters: dict[str, float],
        context: Context = NOWHERE,
    ) -> EntryKey:
        """Make a key, rounding and sorting the parameters."""
        rounded = tuple(sorted((name, round(value, 6)) for name, value in parameters.items()))
        return cls(robot, motion, version, axes, rounded, context)

    def describe(self) -> str:
        """Tell people: 'squat amplitude=0.03 frequency=0.25 on my_robot'."""
        values = " ".join(f"{name}={value:g}" for name, value in self.parameters)
        return f"{self.motion} {values} on {self.robot}"
