"""Whether a robot's file, its URDF and its postures fit together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio

from tsd_casadi.exceptions import RobotFileError

if TYPE_CHECKING:
    from tsd_casadi.robot.robot import Robot

# how far home may leave the soles from lying flat on one plane [m, -]
FLATNESS = 1e-3
# singular value of the contact Jacobian below which a direction counts as lost
RANK_TOLERANCE = 1e-4


def check_robot(robot: Robot) -> None:
    """Refuse a robot that no controller could be made for.

    Raises:
        RobotFileError: If a name is unknown, a limit is missing or exceeded, a
            posture does not stand flat, or the feet depend on each other.
    """
    _check_frames(robot)
    _check_joints(robot)
    _check_torque_limits(robot)
    _check_angles(robot)
    _check_flat_soles(robot)
    _check_mobility(robot)


def _postures(robot: Robot) -> list[tuple[str, str, dict[str, float]]]:
    """List name, field and joint angles of every posture of the file."""
    others = robot.description.postures.items()
    return [
        ("home", "home", robot.description.home),
        *((name, f"postures.{name}", joints) for name, joints in others),
    ]


def _check_frames(robot: Robot) -> None:
    frames = [frame.name for frame in robot.model.frames]
    for kind, parts in (
        ("contacts", robot.description.contacts),
        ("tasks", robot.description.tasks),
    ):
        for index, part in enumerate(parts):
            frame = getattr(part, "frame", None)
            if frame is not None and frame not in frames:
                raise RobotFileError(
                    robot.path,
                    f"{kind}.{index}.frame",
                    f"'{frame}' is no frame of {robot.urdf_path.name}",
                    f"one of {', '.join(frames[1:])}",
                )


def _check_joints(robot: Robot) -> None:
    for _, field, joints in _postures(robot):
        for joint in joints:
            if joint not in robot.joint_names:
                raise RobotFileError(
                    robot.path,
                    f"{field}.{joint}",
                    f"is no joint of {robot.urdf_path.name}",
                    f"one of {', '.join(robot.joint_names)}",
                )


def _check_torque_limits(robot: Robot) -> None:
    for joint, limit in zip(robot.joint_names, robot.torque_limit, strict=True):
        if not 0 < limit < 1e6:
            raise RobotFileError(
                robot.urdf_path,
                f"joint {joint}, limit, effort",
                f"is {limit:g}",
                "a positive torque limit in N m",
            )


def _check_angles(robot: Robot) -> None:
    model = robot.model
    for _, field, joints in _postures(robot):
        for joint, angle in joints.items():
            index = model.joints[model.getJointId(joint)].idx_q
            low, high = model.lowerPositionLimit[index], model.upperPositionLimit[index]
            if not low <= angle <= high:
                raise RobotFileError(
                    robot.path,
                    f"{field}.{joint}",
                    f"is {angle:g} rad",
                    f"a value from {low:g} to {high:g} rad",
                )


def _check_flat_soles(robot: Robot) -> None:
    for name, field, _ in _postures(robot):
        placements = robot.sole_placements(robot.posture(name).q)
        for contact, placement in zip(robot.description.contacts, placements, strict=True):
            height = abs(placement.translation[2])
            tilt = float(np.linalg.norm(placement.rotation[:, 2] - [0, 0, 1]))
            if height > FLATNESS or tilt > FLATNESS:
                raise RobotFileError(
                    robot.path,
                    field,
                    f"leaves {contact.name} {1e3 * height:.1f} mm off the ground plane and "
                    f"tilted by {tilt:.4f} rad",
                    "joint angles with all soles flat on one plane",
                )


def _check_mobility(robot: Robot) -> None:
    """Refuse feet that are not free to accelerate independently of each other."""
    model, q = robot.model, robot.home.q
    data = model.createData()
    rows = [
        pinocchio.computeFrameJacobian(model, data, q, frame, pinocchio.LOCAL)
        for frame in robot.sole_frames
    ]
    rank = int(np.linalg.matrix_rank(np.vstack(rows), tol=RANK_TOLERANCE))
    if rank < 6 * len(rows):
        raise RobotFileError(
            robot.path,
            "contacts",
            f"at home the feet can move in {rank} ways only, six each would be {6 * len(rows)}",
            "legs with at least six joints each and a home posture without straight knees",
        )
