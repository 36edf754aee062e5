r"""What every Cartesian task offers to the QP [cart_joint_accel].

.. math:: \ddot x_t = J_t \ddot q + \dot J_t \dot q

All quantities are in axes parallel to the world's.
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from tsd_casadi.dynamics.symbolic_dynamics import SymbolicDynamics
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_tasks import Gain, gain_matrix
from tsd_casadi.state import Matrix
from tsd_casadi.tasks.activation import activation_levels, blended_weight
from tsd_casadi.tasks.desired_acceleration import feedback_acceleration
from tsd_casadi.tasks.symmetric import (
    coupled_matrix,
    pack_coupling,
    pack_lower_triangle,
    symmetric_matrix,
)
from tsd_casadi.tick.layout import HUGE, Field

Read = Callable[[str], ca.SX]

SHARE = (0.0, 1.0)


@dataclass(frozen=True)
class TaskTerms:
    """A task at one state.

    Attributes:
        J: (k, nv).
        drift: dJ/dt v, (k,).
        error: x_ref - x, (k,) [m, rad].
        error_rate: xd_ref - xd, (k,) [m/s, rad/s].
    """

    J: ca.SX
    drift: ca.SX
    error: ca.SX
    error_rate: ca.SX


class Task(abc.ABC):
    """A task with k axes.

    Attributes:
        name: Name of the task, first part of its fields' names.
        axes: Names of the controlled axes, k of them.
        P: Default stiffness, (k, k) [1/s^2].
        D: Default damping, (k, k) [1/s].
        W: Default weight.
        active: Whether it counts where nothing is said.
    """

    def __init__(
        self,
        name: str,
        axes: tuple[str, ...],
        P: Gain,
        D: Gain,
        W: float,
        active: bool = True,
    ) -> None:
        """Create the task with its defaults; gains are a number, a diagonal or a matrix."""
        self.name = name
        self.axes = axes
        self.P: Matrix = gain_matrix(P, len(axes))
        self.D: Matrix = gain_matrix(D, len(axes))
        self.W = W
        self.active = active

    @property
    def k(self) -> int:
        """Number of controlled axes."""
        return len(self.axes)

    @abc.abstractmethod
    def terms(self, dynamics: SymbolicDynamics, read: Read) -> TaskTerms:
        """Write error, Jacobian and drift as expressions of state and command.

        Args:
            read: Gives a field of the command by name, without the task's.
        """

    @abc.abstractmethod
    def reference_fields(self, robot: Robot) -> tuple[Field, ...]:
        """Describe the fields of the references, at home and at rest by default."""

    def feedback(self, terms: TaskTerms, read: Read) -> ca.SX:
        """Write what the feedback asks for, (k,)."""
        P, D = self._gain("P", read), self._gain("D", read)
        return feedback_acceleration(P, terms.error, D, terms.error_rate)

    def levels(self, read: Read) -> ca.SX:
        """Write how much each axis counts, (k,), 0 to 1."""
        return activation_levels(read("active"), read("mask"))

    def weight(self, read: Read, rest: ca.SX) -> ca.SX:
        """Write the weight matrix as the levels leave it, (k, k).

        Args:
            rest: Weight of what takes over where a level is below 1.
        """
        return blended_weight(symmetric_matrix(read("W"), self.k), self.levels(read), rest)

    @property
    def along(self) -> str:
        """The axes, in words."""
        return f"axes {' '.join(self.axes)}, world"

    @property
    def unit(self) -> str:
        """Unit of x."""
        length = ["m" if axis in ("x", "y", "z") else "rad" for axis in self.axes]
        return length[0] if len(set(length)) == 1 else "m, rad"

    @property
    def error_unit(self) -> str:
        """Unit of the error in a reply."""
        return self.unit

    def fields(self, robot: Robot) -> tuple[Field, ...]:
        """Describe the command's fields of this task, with the robot's defaults."""
        return (*self.reference_fields(robot), *self.gain_fields(), *self.weight_fields())

    def rate_fields(self, rate_unit: str, unit: str) -> tuple[Field, ...]:
        """Describe the references of velocity and acceleration, and the learned term."""
        zero = (0.0,) * self.k
        learned = f"learned term added to the reference acceleration, {self.along}"
        return (
            self._field("reference_velocity", rate_unit, self.along, zero),
            self._field("reference_acceleration", unit, self.along, zero),
            self._field("feedforward", unit, learned, zero),
        )

    def gain_fields(self) -> tuple[Field, ...]:
        """Describe the fields of the feedback's gains."""
        return (
            *self._gain_fields("P", "1/s^2", "stiffness", self.P),
            *self._gain_fields("D", "1/s", "damping", self.D),
        )

    def weight_fields(self) -> tuple[Field, ...]:
        """Describe the fields that say how much the task counts."""
        weight = pack_lower_triangle(self.W * np.eye(self.k))
        return (
            self._field(
                "W", "1", f"lower triangle of the weight matrix, row by row, {self.along}", weight
            ),
            self._field("active", "1", "1: track the task, 0: leave it out", [self.active], SHARE),
            self._field("mask", "1", f"share of 'active', {self.along}", [1] * self.k, SHARE),
        )

    def _gain(self, name: str, read: Read) -> ca.SX:
        diagonal = read(name)
        return diagonal if self.k == 1 else coupled_matrix(diagonal, read(f"{name}_coupling"))

    def _gain_fields(self, name: str, unit: str, words: str, gain: Matrix) -> tuple[Field, ...]:
        diagonal = self._field(name, unit, f"{words}, {self.along}", np.diag(gain), (0.0, HUGE))
        if self.k == 1:
            return (diagonal,)
        below = f"{words} matrix below its diagonal, row by row, {self.along}"
        return diagonal, self._field(f"{name}_coupling", unit, below, pack_coupling(gain))

    def _field(
        self,
        name: str,
        unit: str,
        description: str,
        default: Sequence[float] | Matrix,
        bounds: tuple[float, float] = (-HUGE, HUGE),
    ) -> Field:
        values = tuple(map(float, default))
        lower, upper = bounds
        return Field(
            f"{self.name}.{name}", len(values), unit, description, lower, upper, default=values
        )
