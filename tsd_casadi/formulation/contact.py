"""What every kind of contact brings to the QP: its fields of the command and its rows."""

from __future__ import annotations

import abc
from collections.abc import Callable
from typing import ClassVar

import casadi as ca

from tsd_casadi.constraints.friction import friction
from tsd_casadi.constraints.rows import BASE_AXES, Rows
from tsd_casadi.constraints.unilateral_force import unilateral_force
from tsd_casadi.dynamics.symbolic_dynamics import SymbolicDynamics
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import PointFile, SoleFile
from tsd_casadi.tick.layout import Field

Read = Callable[[str], ca.SX]

# Of the robot's weight, what a foot may carry by default. One foot carries all of it while
# the other is lifted, and accelerations add to it. While a contact fades this much is taken
# from it over the ramp: more makes the ramp steeper at its end.
MAXIMUM_LOAD = 2.0

# a contact's share of the reply, [force; moment] whatever its kind
WRENCH = len(BASE_AXES)


class Contact(abc.ABC):
    """A contact that carries the first components of [force; moment].

    Each component it carries comes with one row that keeps it from accelerating.

    Attributes:
        name: Name of the contact, first part of its fields' and rows' names.
        frame: Name of its frame.
        size: How many components it carries.
        carried: What they are, in words.
        components: The same with their order.
        unit: Their units.
        weight_unit: Units of a weight on their squares.
        axes: Their axes, in words.
        reply_axes: Axes of several such contacts' wrenches in the reply, in words.
    """

    size: ClassVar[int]
    carried: ClassVar[str]
    components: ClassVar[str]
    unit: ClassVar[str]
    weight_unit: ClassVar[str]
    axes: ClassVar[str]
    reply_axes: ClassVar[str]

    def __init__(self, file: SoleFile | PointFile, frame: str) -> None:
        """Take a contact's name and numbers from the robot file, and its frame in the model."""
        self.name = file.name
        self.frame = frame
        self._friction, self._minimum_force = file.friction, file.minimum_force

    @abc.abstractmethod
    def kinematics(self, dynamics: SymbolicDynamics) -> tuple[ca.SX, ca.SX]:
        """Write Jacobian (size, nv) and drift (size,) of what may not accelerate."""

    def fields(self, robot: Robot) -> tuple[Field, ...]:
        """Describe the command's fields of this contact, with the robot's defaults.

        The wanted forces share the weight between all contacts.
        """
        name = self.name
        share = robot.weight / len(robot.description.contacts)
        weights = robot.description.regularization
        wanted = (0.0, 0.0, share, 0.0, 0.0, 0.0)
        weight = (weights.force,) * 3 + (weights.moment,) * 3
        return (
            Field(
                f"{name}.active",
                1,
                "1",
                f"1: in contact, 0: free, its {self.carried} is zero; in between it stands and "
                "may carry a share",
                lower=0.0,
                upper=1.0,
                default=(1.0,),
            ),
            Field(
                f"{name}.friction",
                1,
                "1",
                "Coulomb coefficient",
                lower=0.0,
                default=(self._friction,),
            ),
            *self._shape_fields(),
            Field(
                f"{name}.minimum_force",
                1,
                "N",
                "least normal force with active = 1",
                lower=0.0,
                default=(self._minimum_force,),
            ),
            Field(
                f"{name}.maximum_force",
                1,
                "N",
                "largest normal force with active = 1",
                lower=0.0,
                default=(MAXIMUM_LOAD * robot.weight,),
            ),
            Field(
                f"{name}.lambda_des",
                self.size,
                self.unit,
                f"wanted {self.components} while all contacts have active = 1, {self.axes}",
                default=wanted[: self.size],
            ),
            Field(
                f"{name}.W_lambda",
                self.size,
                self.weight_unit,
                f"diagonal of the weight on the {self.carried}",
                lower=0.0,
                default=weight[: self.size],
            ),
        )

    def cone(self, read: Read, nv: int, selection: ca.SX) -> list[Rows]:
        """Write the inequalities that keep the foot on the ground.

        Args:
            read: Gives a field of the command by name, without the contact's.
            selection: (size, l), picks this contact's forces out of lambda.
        """
        return [
            friction(self.name, read("friction"), nv, selection),
            unilateral_force(
                self.name,
                read("minimum_force"),
                read("maximum_force"),
                read("active"),
                nv,
                selection,
            ),
        ]

    def _shape_fields(self) -> tuple[Field, ...]:
        """Describe the fields that only a foot of this kind has."""
        return ()
