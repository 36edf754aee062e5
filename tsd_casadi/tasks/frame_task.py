"""The task that tracks the pose of a frame in SE(3)."""

from __future__ import annotations

import casadi as ca

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


def rotation_matrix(quaternion: ca.SX) -> ca.SX:
    """Convert a quaternion xyzw, normalised first, to a rotation matrix.

    Args:
        quaternion: (4,).

    Returns:
        (3, 3).
    """
    unit = quaternion / ca.norm_2(quaternion)
    x = ca.skew(unit[:3])
    return ca.SX.eye(3) + 2 * unit[3] * x + 2 * x @ x


def rotation_vector(R: ca.SX) -> ca.SX:
    r"""Compute a rotation's logarithm, :math:`\theta u` with :math:`0 \le \theta \le \pi`.

    Taken from the unit quaternion (x, w) as 2 atan2(\|x\|, w) x / \|x\|, which
    stays accurate up to half a turn.

    Args:
        R: (3, 3).

    Returns:
        (3,) [rad].
    """
    quaternion = _quaternion(R)
    x, w = quaternion[:3], quaternion[3]
    s = ca.norm_2(x)
    # theta / sin(theta / 2) tends to two; its series avoids 0 / 0
    small = s < 1e-6
    ratio = ca.if_else(small, 2 + s**2 / 3, 2 * ca.atan2(s, w) / ca.if_else(small, 1, s))
    return ratio * x


def _quaternion(R: ca.SX) -> ca.SX:
    """Convert a rotation to a unit quaternion xyzw, w >= 0, by its largest component."""
    diagonal = [R[i, i] for i in range(3)]
    squares = [1 + sum(diagonal)]
    squares += [1 + 2 * d - sum(diagonal) for d in diagonal]
    skew = [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
    xy, xz, yz = R[0, 1] + R[1, 0], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1]
    candidates = [
        ca.vertcat(*skew, squares[0]),
        ca.vertcat(squares[1], xy, xz, skew[0]),
        ca.vertcat(xy, squares[2], yz, skew[1]),
        ca.vertcat(xz, yz, squares[3], skew[2]),
    ]
    largest, chosen = squares[0], candidates[0]
    for square, candidate in zip(squares[1:], candidates[1:], strict=True):
        chosen = ca.if_else(square > largest, candidate, chosen)
        largest = ca.fmax(square, largest)
    return ca.if_else(chosen[3] < 0, -1, 1) * chosen / ca.norm_2(chosen)
