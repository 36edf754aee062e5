"""A robot: its file, its rigid-body model and its home posture."""

from __future__ import annotations

import hashlib
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

import tsd_models
from tsd_casadi.exceptions import RobotFileError, UnknownRobot
from tsd_casadi.robot_file import RobotFile, read_robot_file
from tsd_casadi.state import State, Vector

# how far home may leave the soles from lying flat on one plane [m, -]
FLATNESS = 1e-3
# singular value of the contact Jacobian below which a direction counts as lost
RANK_TOLERANCE = 1e-4


class Robot:
    """A robot as the controller knows it.

    Attributes:
        path: The robot file.
        description: Its checked content.
        name: Name of the robot.
        model: Numeric ``pinocchio.Model`` with a free-flyer base.
        joint_names: Actuated joints in the order of q, v and tau.
        torque_limit: Bound of |tau|, shape (n,) [N m].
        fingerprint: Hash of the robot file and the URDF.
    """

    def __init__(self, path: Path) -> None:
        """Load and check a robot file.

        Args:
            path: The robot file.

        Raises:
            RobotFileError: If the file or what it names cannot be used; it says
                which file, which field and what was expected.
        """
        self.path = path.resolve()
        self.description: RobotFile = read_robot_file(self.path)
        self.name = self.description.name
        self.model = self._build_model()
        self.joint_names: list[str] = list(self.model.names)[2:]
        self._check_names()
        self.torque_limit: Vector = np.array(self.model.effortLimit[6:])
        self._check_limits()
        digest = hashlib.sha256(self.path.read_bytes())
        digest.update(self.urdf_path.read_bytes())
        self.fingerprint = digest.hexdigest()[:16]
        self._check_home()
        self._check_mobility()

    @property
    def n(self) -> int:
        """Number of actuated joints."""
        return len(self.joint_names)

    @property
    def nq(self) -> int:
        """Size of q, 7 + n."""
        return int(self.model.nq)

    @property
    def nv(self) -> int:
        """Size of v, 6 + n."""
        return int(self.model.nv)

    @property
    def urdf_path(self) -> Path:
        """The URDF."""
        return self.path.parent / self.description.urdf

    @property
    def scene_path(self) -> Path:
        """The MuJoCo scene."""
        return self.path.parent / self.description.scene

    @cached_property
    def weight(self) -> float:
        """Weight of the whole robot [N]."""
        gravity = float(np.linalg.norm(self.model.gravity.linear))
        return float(pinocchio.computeTotalMass(self.model)) * gravity

    @cached_property
    def home(self) -> State:
        """Home posture at rest, soles flat on the ground plane z = 0."""
        q = pinocchio.neutral(self.model)
        for joint, angle in self.description.home.items():
            q[self.model.joints[self.model.getJointId(joint)].idx_q] = angle
        placements = self._contact_placements(q)
        q[2] -= np.mean([placement.translation[2] for placement in placements])
        return State(q=q, v=np.zeros(self.nv))

    @cached_property
    def home_com(self) -> Vector:
        """Centre of mass at home, shape (3,) [m], world frame."""
        return np.array(pinocchio.centerOfMass(self.model, self.model.createData(), self.home.q))

    def frame_placement(self, frame: str, q: Vector) -> tuple[Vector, Vector]:
        """Where a frame is.

        Args:
            frame: Name of a frame of the URDF.
            q: Configuration, shape (nq,).

        Returns:
            Position [m] and orientation as a quaternion xyzw, world frame.
        """
        data = self.model.createData()
        pinocchio.framesForwardKinematics(self.model, data, q)
        placement = data.oMf[self.model.getFrameId(frame)]
        quaternion = pinocchio.Quaternion(placement.rotation).coeffs()
        return np.array(placement.translation), np.array(quaternion)

    def _error(self, field: str, found: str, expected: str) -> RobotFileError:
        return RobotFileError(self.path, field, found, expected)

    def _build_model(self) -> Any:
        for field, path in (("urdf", self.urdf_path), ("scene", self.scene_path)):
            if not path.is_file():
                raise self._error(field, f"'{path}' is no file", "a path relative to this file")
        try:
            model = pinocchio.buildModelFromUrdf(
                str(self.urdf_path), pinocchio.JointModelFreeFlyer()
            )
        except (ValueError, RuntimeError, KeyError) as error:
            raise RobotFileError(
                self.urdf_path, "", f"cannot be parsed ({error})", "a valid URDF"
            ) from error
        n = model.njoints - 2
        if model.nv != 6 + n or model.nq != 7 + n:
            raise RobotFileError(
                self.urdf_path,
                "",
                "has joints with more than one degree of freedom, or continuous ones",
                "revolute, prismatic and fixed joints",
            )
        return model

    def _check_names(self) -> None:
        frames = [frame.name for frame in self.model.frames]
        for kind, parts in (
            ("contacts", self.description.contacts),
            ("tasks", self.description.tasks),
        ):
            for index, part in enumerate(parts):
                frame = getattr(part, "frame", None)
                if frame is not None and frame not in frames:
                    raise self._error(
                        f"{kind}.{index}.frame",
                        f"'{frame}' is no frame of {self.urdf_path.name}",
                        f"one of {', '.join(frames[1:])}",
                    )
        for joint in self.description.home:
            if joint not in self.joint_names:
                raise self._error(
                    f"home.{joint}",
                    f"is no joint of {self.urdf_path.name}",
                    f"one of {', '.join(self.joint_names)}",
                )

    def _check_limits(self) -> None:
        for joint, limit in zip(self.joint_names, self.torque_limit, strict=True):
            if not 0 < limit < 1e6:
                raise RobotFileError(
                    self.urdf_path,
                    f"joint {joint}, limit, effort",
                    f"is {limit:g}",
                    "a positive torque limit in N m",
                )
        for joint, angle in self.description.home.items():
            index = self.model.joints[self.model.getJointId(joint)].idx_q
            low = self.model.lowerPositionLimit[index]
            high = self.model.upperPositionLimit[index]
            if not low <= angle <= high:
                raise self._error(
                    f"home.{joint}", f"is {angle:g} rad", f"a value from {low:g} to {high:g} rad"
                )

    def _contact_placements(self, q: Vector) -> list[Any]:
        data = self.model.createData()
        pinocchio.framesForwardKinematics(self.model, data, q)
        return [
            data.oMf[self.model.getFrameId(contact.frame)] for contact in self.description.contacts
        ]

    def _check_mobility(self) -> None:
        """The feet must be free to accelerate independently of each other."""
        data = self.model.createData()
        rows = [
            pinocchio.computeFrameJacobian(
                self.model,
                data,
                self.home.q,
                self.model.getFrameId(contact.frame),
                pinocchio.LOCAL,
            )
            for contact in self.description.contacts
        ]
        rank = int(np.linalg.matrix_rank(np.vstack(rows), tol=RANK_TOLERANCE))
        if rank < 6 * len(rows):
            raise self._error(
                "contacts",
                f"at home the feet can move in {rank} ways only, six each would be {6 * len(rows)}",
                "legs with at least six joints each and a home posture without straight knees",
            )

    def _check_home(self) -> None:
        for contact, placement in zip(
            self.description.contacts, self._contact_placements(self.home.q), strict=True
        ):
            height = abs(placement.translation[2])
            tilt = float(np.linalg.norm(placement.rotation[:, 2] - [0, 0, 1]))
            if height > FLATNESS or tilt > FLATNESS:
                raise self._error(
                    "home",
                    f"leaves {contact.name} {1e3 * height:.1f} mm off the ground plane and "
                    f"tilted by {tilt:.4f} rad",
                    "joint angles with all soles flat on one plane",
                )


def load_robot(robot: str | Path) -> Robot:
    """Load a robot by name or by file.

    Args:
        robot: Name of a shipped robot, or path of a robot file.

    Returns:
        The robot.

    Raises:
        UnknownRobot: If it is neither.
        RobotFileError: If the robot file cannot be used.
    """
    shipped = tsd_models.robot_files()
    if str(robot) in shipped:
        return Robot(shipped[str(robot)])
    path = Path(robot).expanduser()
    if not path.is_file():
        raise UnknownRobot(str(robot), list(shipped))
    return Robot(path)
