r"""What every Cartesian task offers to the QP [cart_joint_accel].

.. math:: \ddot x_t = J_t \ddot q + \dot J_t \dot q

All quantities are in axes parallel to the world's.
"""

from __future__ import annotations

import abc
from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np

from tsd_casadi.dynamics.symbolic_dynamics import SymbolicDynamics
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector
from tsd_casadi.tick.layout import Field

Read = Callable[[str], ca.SX]


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
        P: Default stiffness [1/s^2].
        D: Default damping [1/s].
        W: Default weight.
        active: Whether it counts where nothing is said.
    """

    def __init__(
        self,
        name: str,
        axes: tuple[str, ...],
        P: float,
        D: float,
        W: float,
        active: bool = True,
    ) -> None:
        """Create the task with its defaults."""
        self.name = name
        self.axes = axes
        self.P = P
        self.D = D
        self.W = W
        self.active = active

    @property
    def k(self) -> int:
        """Number of controlled axes."""
        return len(self.axes)

    @abc.abstractmethod
    def reference_field(self, robot: Robot) -> Field:
        """Describe the field that holds x_ref, with the home posture as default."""

    @abc.abstractmethod
    def terms(self, dynamics: SymbolicDynamics, read: Read) -> TaskTerms:
        """Write error, Jacobian and drift as expressions of state and command.

        Args:
            read: Gives a field of the command by name.
        """

    def fields(self, robot: Robot) -> tuple[Field, ...]:
        """Describe the command's fields of this task, with the robot's defaults."""
        along = f"axes {' '.join(self.axes)}, world"
        zero = (0.0,) * self.k
        length = ["m" if axis in ("x", "y", "z") else "rad" for axis in self.axes]
        unit = length[0] if len(set(length)) == 1 else "m, rad"
        weight = np.diag(np.full(self.k, self.W))[np.tril_indices(self.k)]
        return (
            self.reference_field(robot),
            Field(f"{self.name}.reference_velocity", self.k, f"{unit}/s", along, default=zero),
            Field(
                f"{self.name}.reference_acceleration", self.k, f"{unit}/s^2", along, default=zero
            ),
            Field(
                f"{self.name}.feedforward",
                self.k,
                f"{unit}/s^2",
                f"learned term added to the reference acceleration, {along}",
                default=zero,
            ),
            Field(
                f"{self.name}.P",
                self.k,
                "1/s^2",
                f"stiffness, {along}",
                lower=0.0,
                default=(self.P,) * self.k,
            ),
            Field(
                f"{self.name}.D",
                self.k,
                "1/s",
                f"damping, {along}",
                lower=0.0,
                default=(self.D,) * self.k,
            ),
            Field(
                f"{self.name}.W",
                len(weight),
                "1",
                f"lower triangle of the weight matrix, row by row, {along}",
                default=tuple(weight),
            ),
            Field(
                f"{self.name}.active",
                1,
                "1",
                "1: track the task, 0: leave it out",
                default=(float(self.active),),
                switch=True,
            ),
        )


def symmetric_matrix(lower_triangle: ca.SX, k: int) -> ca.SX:
    """Put a symmetric matrix together from its lower triangle, row by row.

    Args:
        lower_triangle: (k (k + 1) / 2,).
        k: Number of rows.

    Returns:
        (k, k).
    """
    matrix = ca.SX.zeros(k, k)
    for index, (row, column) in enumerate(zip(*np.tril_indices(k), strict=True)):
        matrix[int(row), int(column)] = lower_triangle[index]
        matrix[int(column), int(row)] = lower_triangle[index]
    return matrix


def pack_lower_triangle(matrix: Vector) -> Vector:
    """Take a symmetric matrix's lower triangle, row by row, as the command has it.

    Args:
        matrix: (k, k).

    Returns:
        (k (k + 1) / 2,).
    """
    rows, columns = np.tril_indices(matrix.shape[0])
    return np.asarray(matrix[rows, columns], dtype=float)
