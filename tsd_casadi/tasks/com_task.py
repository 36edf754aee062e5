"""The task that tracks the centre of mass, world frame."""

from __future__ import annotations

from tsd_casadi.dynamics.symbolic_dynamics import SymbolicDynamics
from tsd_casadi.robot.robot import Robot
from tsd_casadi.tasks.task import Read, Task, TaskTerms
from tsd_casadi.tick.layout import Field


class ComTask(Task):
    r"""Tracks :math:`c` with error :math:`c_{ref} - c`, world frame [m]."""

    def reference_fields(self, robot: Robot) -> tuple[Field, ...]:
        """Describe c_ref, (3,) [m], world frame, axes not controlled ignored, and its rates."""
        place = Field(
            f"{self.name}.reference",
            3,
            "m",
            "centre of mass, world frame",
            default=tuple(robot.home_com),
        )
        return place, *self.rate_fields("m/s", "m/s^2")

    def terms(self, dynamics: SymbolicDynamics, read: Read) -> TaskTerms:
        """Write error, Jacobian and drift of the controlled axes, world frame."""
        rows = ["xyz".index(axis) for axis in self.axes]
        com = dynamics.center_of_mass()
        J = com.J[rows, :]
        return TaskTerms(
            J=J,
            drift=com.drift[rows],
            error=(read("reference") - com.position)[rows],
            error_rate=read("reference_velocity") - J @ dynamics.v,
        )
