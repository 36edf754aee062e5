"""A point foot in the QP: three rows and a force in world axes.

A point foot is a ball at the end of a leg: its link turns while the leg moves,
the ground does not. So its rows and its force are in axes parallel to the
world's, and its normal is the world's z: the ground is the plane z = 0.
"""

from __future__ import annotations

import casadi as ca

from tsd_casadi.dynamics.symbolic_dynamics import SymbolicDynamics
from tsd_casadi.formulation.contact import Contact


class PointContact(Contact):
    """A point does not move and may turn; it carries a force in world axes, normal along z."""

    size = 3
    carried = "force"
    components = "force"
    unit = "N"
    weight_unit = "1/N^2"
    axes = "world axes"
    reply_axes = "world axes, moments zero, of"

    def kinematics(self, dynamics: SymbolicDynamics) -> tuple[ca.SX, ca.SX]:
        """Write the Jacobian (3, nv) and drift (3,) of the point, world axes."""
        point = dynamics.frame(self.frame, local=False)
        return point.J[:3, :], point.drift[:3]
