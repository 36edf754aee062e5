"""Pose of a frame in SE(3)."""

from __future__ import annotations

import casadi as ca

from tsd_casadi.layout import Field
from tsd_casadi.robot import Robot
from tsd_casadi.robot_file import FRAME_AXES
from tsd_casadi.symbolic_dynamics import SymbolicDynamics
from tsd_casadi.tasks.task import Read, Task, TaskTerms


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
        self, name: str, frame: str, axes: tuple[str, ...], P: float, D: float, W: float
    ) -> None:
        """Create the task with its defaults."""
        super().__init__(name, axes, P, D, W)
        self.frame = frame

    def reference_field(self, robot: Robot) -> Field:
        """p_ref (3,) [m] and quaternion xyzw (4,), world frame."""
        position, quaternion = robot.frame_placement(self.frame, robot.home.q)
        return Field(
            f"{self.name}.reference",
            7,
            "m, 1",
            f"pose of frame {self.frame}: position, unit quaternion xyzw, world frame",
            default=(*position, *quaternion),
            unit_quaternion=3,
        )

    def terms(self, dynamics: SymbolicDynamics, read: Read) -> TaskTerms:
        """Terms of the controlled axes, world axes."""
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


def rotation_matrix(quaternion: ca.SX) -> ca.SX:
    """Rotation matrix of a quaternion xyzw, which is normalised first.

    Args:
        quaternion: (4,).

    Returns:
        (3, 3).
    """
    unit = quaternion / ca.norm_2(quaternion)
    x = ca.skew(unit[:3])
    return ca.SX.eye(3) + 2 * unit[3] * x + 2 * x @ x


def rotation_vector(R: ca.SX) -> ca.SX:
    r"""Logarithm of a rotation, :math:`\theta u` with :math:`0 \le \theta < \pi`.

    Args:
        R: (3, 3).

    Returns:
        (3,) [rad]; near theta = pi the axis is ill-defined, as for any
        logarithm.
    """
    sine = ca.vertcat(R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]) / 2
    s = ca.norm_2(sine)
    c = (ca.trace(R) - 1) / 2
    # theta / sin(theta) tends to one; its series avoids 0 / 0
    small = s < 1e-6
    ratio = ca.if_else(small, 1 + s**2 / 6, ca.atan2(s, c) / ca.if_else(small, 1, s))
    return ratio * sine
