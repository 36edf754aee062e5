"""A flat foot in the QP: six rows and a wrench in the sole frame."""

from __future__ import annotations

import casadi as ca

from tsd_casadi.constraints.center_of_pressure import center_of_pressure
from tsd_casadi.constraints.normal_torque import normal_torque
from tsd_casadi.constraints.rows import Rows
from tsd_casadi.dynamics.symbolic_dynamics import SymbolicDynamics
from tsd_casadi.formulation.contact import Contact, Read
from tsd_casadi.robot.robot_file_sections import SoleFile
from tsd_casadi.tick.layout import Field


class SoleContact(Contact):
    """A sole neither moves nor turns; it carries a wrench in its own axes, normal along its z."""

    size = 6
    carried = "wrench"
    components = "wrench [force; moment]"
    unit = "N, N m"
    weight_unit = "1/N^2, 1/(N m)^2"
    axes = "sole frame"
    reply_axes = "the sole frames of"

    def __init__(self, file: SoleFile, frame: str) -> None:
        """Take a sole of the robot file, and its frame in the model."""
        super().__init__(file, frame)
        self._torsional_friction = file.torsional_friction
        self._extents = (*file.x, *file.y)

    def kinematics(self, dynamics: SymbolicDynamics) -> tuple[ca.SX, ca.SX]:
        """Write the Jacobian (6, nv) and drift (6,) of the sole, sole axes."""
        sole = dynamics.frame(self.frame, local=True)
        return sole.J, sole.drift

    def cone(self, read: Read, nv: int, selection: ca.SX) -> list[Rows]:
        """Write centre of pressure, friction, normal torque and unilateral force."""
        extents, gamma = read("extents"), read("torsional_friction")
        slide, push = super().cone(read, nv, selection)
        return [
            center_of_pressure(self.name, extents, nv, selection),
            slide,
            normal_torque(self.name, gamma, nv, selection),
            push,
        ]

    def _shape_fields(self) -> tuple[Field, ...]:
        return (
            Field(
                f"{self.name}.torsional_friction",
                1,
                "m",
                "bound of |normal torque| / normal force",
                lower=0.0,
                default=(self._torsional_friction,),
            ),
            Field(
                f"{self.name}.extents",
                4,
                "m",
                "sole: x low, x high, y low, y high, sole frame",
                default=self._extents,
            ),
        )
