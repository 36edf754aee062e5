"""The task that tracks the pose of a frame in SE(3)."""

from __future__ import annotations

import casadi as ca

from tsd_casadi.dynamics.rotation import rotation_matrix, rotation_vector
from tsd_casadi.dynamics.symbolic_dynamics import SymbolicDynamics
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import FRAME_AXES
from tsd_casadi.robot.robot_file_tasks import Gain
from tsd_casadi.tasks.task import Read, Task, TaskTerms
from tsd_casadi.tick.layout import Field


class FrameTask(Task):
    r"""Tracks the pose (p, R) of a frame; every quantity is in world axes.

    .. math:: e = \begin{pmatrix} p_{ref} - p \\ \log(R_{ref} R^T) \end{pmatrix}

    The angular error is the rotation vector, in world axes, that turns the
    frame into its reference. J is Pinocchio's LOCAL_WORLD_ALIGNED Jacobian, so
    that :math:`\dot e = -J \dot q` at zero error.

    Attributes:
        frame: Name of the frame.
    """

    def __init__(
        self,
        name: str,
        frame: str,
        axes: tuple[str, ...],
        P: Gain,
        D: Gain,
        W: float,
        active: bool = True,
    ) -> None:
        """Create the task with its defaults."""
        super().__init__(name, axes, P, D, W, active)
        self.frame = frame

    def reference_fields(self, robot: Robot) -> tuple[Field, ...]:
        """Describe p_ref (3,) [m] and quaternion xyzw (4,), world frame, and their rates."""
        position, quaternion = robot.frame_placement(self.frame, robot.home.q)
        pose = Field(
            f"{self.name}.reference",
            7,
            "m, 1",
            f"pose of frame {self.frame}: position, unit quaternion xyzw, world frame",
            default=(*position, *quaternion),
            unit_quaternion=3,
        )
        return pose, *self.rate_fields(f"{self.unit}/s", f"{self.unit}/s^2")

    def terms(self, dynamics: SymbolicDynamics, read: Read) -> TaskTerms:
        """Write error, Jacobian and drift of the controlled axes, world axes."""
        rows = [FRAME_AXES.index(axis) for axis in self.axes]
        frame = dynamics.frame(self.frame, local=False)
        reference = read("reference")
        R_ref = rotation_matrix(reference[3:])
        error = ca.vertcat(reference[:3] - frame.position, rotation_vector(R_ref @ frame.R.T))
        J = frame.J[rows, :]
        return TaskTerms(
            J=J,
            drift=frame.drift[rows],
            error=error[rows],
            error_rate=read("reference_velocity") - J @ dynamics.v,
        )
