r"""The task that holds the angular momentum about the centre of mass.

.. math:: \dot L = A_\omega \ddot q + \dot A_\omega v

needs nothing but the base's rows of the dynamics (Wensing and Orin, Improved computation of
the humanoid centroidal dynamics, IJHR 2016): M_u v is the momentum of all links and
M_u qdd + h_u its rate and the weight, both in the base frame, and the weight has no moment
about the centre of mass c,

.. math:: A_\omega = R (M_{u,\omega} - [c]_\times M_{u,v}), \qquad
    \dot A_\omega v = R (h_{u,\omega} - c \times h_{u,v}).
"""

from __future__ import annotations

import casadi as ca

from tsd_casadi.dynamics.symbolic_dynamics import SymbolicDynamics
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import ROTATIONS
from tsd_casadi.robot.robot_file_tasks import Gain
from tsd_casadi.tasks.task import Read, Task, TaskTerms
from tsd_casadi.tick.layout import Field


class AngularMomentumTask(Task):
    r"""Tracks L / I_0, the angular velocity that the whole robot has on average [rad/s].

    I_0 is a constant, the robot's mean inertia at home: with it weights and gains are of
    the size of those of other rotations. World axes. There is no place to be at, so there
    is no stiffness: the feedback is D (L_ref - L) / I_0, and what a reply has for an error
    is (L_ref - L) / I_0.

    Attributes:
        inertia: I_0 [kg m^2].
    """

    def __init__(
        self,
        name: str,
        axes: tuple[str, ...],
        D: Gain,
        W: float,
        inertia: float,
        active: bool = True,
    ) -> None:
        """Create the task with its defaults."""
        super().__init__(name, axes, 0.0, D, W, active)
        self.inertia = inertia

    @property
    def error_unit(self) -> str:
        """Unit of the error in a reply."""
        return "rad/s"

    @property
    def along(self) -> str:
        """The axes and what is meant, in words."""
        return f"angular momentum over {self.inertia:.4g} kg m^2, {super().along}"

    def reference_fields(self, robot: Robot) -> tuple[Field, ...]:
        """Describe L_ref / I_0, its rate and the learned term."""
        return self.rate_fields("rad/s", "rad/s^2")

    def gain_fields(self) -> tuple[Field, ...]:
        """Describe the field of the damping."""
        return self._gain_fields("D", "1/s", "damping", self.D)

    def feedback(self, terms: TaskTerms, read: Read) -> ca.SX:
        """Write D (L_ref - L) / I_0, (k,)."""
        return self._gain("D", read) @ terms.error_rate

    def terms(self, dynamics: SymbolicDynamics, read: Read) -> TaskTerms:
        """Write error, Jacobian and drift of the controlled axes, world axes."""
        rows = [ROTATIONS.index(axis) for axis in self.axes]
        M, h, R = dynamics.mass_matrix(), dynamics.bias_forces(), dynamics.base_rotation()
        # the base's rows of M begin with m and m [c]x
        c = ca.inv_skew(M[3:6, :3]) / M[0, 0]
        about = ca.horzcat(-ca.skew(c), ca.SX.eye(3))
        J = (R @ about @ M[:6, :] / self.inertia)[rows, :]
        rate = read("reference_velocity") - J @ dynamics.v
        drift = (R @ about @ h[:6] / self.inertia)[rows]
        return TaskTerms(J=J, drift=drift, error=rate, error_rate=rate)
