"""A robot: its file, its rigid-body model and its home posture."""

from __future__ import annotations

import hashlib
import os
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

import tsd_models
from tsd_casadi.exceptions import InvalidValue, UnknownRobot
from tsd_casadi.robot.checks import check_robot
from tsd_casadi.robot.description import Kind, read_description
from tsd_casadi.robot.description_path import resolve_path
from tsd_casadi.robot.fingerprints import body_fingerprint, formulation_fingerprint
from tsd_casadi.robot.foot import Foot, make_foot
from tsd_casadi.robot.joint_patterns import values_by_joint
from tsd_casadi.robot.rigid_body_model import RigidBodyModel
from tsd_casadi.robot.robot_file import RobotFile, read_robot_file
from tsd_casadi.state import State, Vector

# of the acceleration limit, which is meant for the mere limb: under the body's weight
# torques brake legs at less
BRAKING = 0.1


class Robot:
    """A robot as the controller knows it.

    Attributes:
        path: The robot file.
        description: Its checked content.
        name: Name of the robot.
        source_path: The description of links and joints.
        scene_path: The MuJoCo scene; None where it is made from the model.
        bodies: How the model was made.
        model: Numeric ``pinocchio.Model`` with a free-flyer base.
        joint_names: Actuated joints in the order of q, v and tau.
        torque_limit: Bound of |tau|, shape (n,) [N m].
        stall_torque: Torque that a motor's line of torque over speed has at rest, shape
            (n,) [N m], infinite where the file gives none.
        no_load_speed: Speed at which that line is zero, shape (n,) [rad/s], as above.
        acceleration_limit: Bound of |joint acceleration|, shape (n,) [rad/s^2].
        braking: Acceleration that a joint counts on to stop, shape (n,) [rad/s^2].
        velocity_limit: Bound of |joint velocity|, shape (n,) [rad/s], infinite where
            the description gives none.
        position_limits: Least and largest joint angles, shape (n,) each [rad].
        fingerprint: Hash of the robot file and the description of links and joints.
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
        described = self.description
        kind: Kind = "mjcf" if described.urdf is None else "urdf"
        self.source_path = resolve_path(self.path, kind, described.source)
        scene = described.scene
        self.scene_path = None if scene is None else resolve_path(self.path, "scene", scene)
        source = read_description(self.source_path, kind)
        digest = hashlib.sha256(self.path.read_bytes())
        digest.update(source.text.encode() if source.expanded else self.source_path.read_bytes())
        self.fingerprint = digest.hexdigest()[:16]
        self.bodies = RigidBodyModel(self.path, described, source)
        self.model = self.bodies.model
        self.joint_names: list[str] = list(self.model.names)[2:]
        self.torque_limit: Vector = np.array(self.model.upperEffortLimit[6:])
        lines = values_by_joint(self.path, "torque_speed", described.torque_speed, self.joint_names)
        self.stall_torque: Vector = np.full(self.n, np.inf)
        self.no_load_speed: Vector = np.full(self.n, np.inf)
        for joint, line in lines.items():
            index = self.joint_names.index(joint)
            self.stall_torque[index] = line.stall_torque
            self.no_load_speed[index] = line.no_load_speed
        accelerations = values_by_joint(
            self.path, "acceleration", described.acceleration, self.joint_names
        )
        self.acceleration_limit: Vector = np.array(
            [accelerations.get(name, described.limits.acceleration) for name in self.joint_names]
        )
        self.braking: Vector = BRAKING * self.acceleration_limit
        self.velocity_limit: Vector = _velocity_limit(self.model)
        self.position_limits: tuple[Vector, Vector] = (
            np.array(self.model.lowerPositionLimit[7:]),
            np.array(self.model.upperPositionLimit[7:]),
        )
        check_robot(self)

    def __repr__(self) -> str:
        """Name the robot and what it has."""
        parts = (self.description.contacts, self.description.all_tasks)
        contacts, tasks = (", ".join(part.name for part in each) for each in parts)
        return f"<Robot {self.name}: {self.n} joints; contacts {contacts}; tasks {tasks}>"

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

    @cached_property
    def body_fingerprint(self) -> str:
        """Hash of kinematics, masses and inertias: what was learned depends on them."""
        return body_fingerprint(self.model, self.description.base_orientation)

    @cached_property
    def formulation_fingerprint(self) -> str:
        """Hash of tasks, contacts and cost terms, not of gains, limits or ranges."""
        return formulation_fingerprint(self.description)

    @cached_property
    def weight(self) -> float:
        """Weight of the whole robot [N]."""
        gravity = float(np.linalg.norm(self.model.gravity.linear))
        return float(pinocchio.computeTotalMass(self.model)) * gravity

    @cached_property
    def home(self) -> State:
        """Home posture at rest, soles flat on the ground plane z = 0."""
        return self._standing(self.description.home)

    def posture(self, name: str) -> State:
        """Compute a posture of the file at rest, soles flat on the ground plane z = 0.

        Args:
            name: 'home' or one of the file's ``postures``.

        Raises:
            InvalidValue: If there is none of that name.
        """
        if name == "home":
            return self.home
        postures = self.description.postures
        if name not in postures:
            raise InvalidValue("posture", f"'{name}'", f"one of {', '.join(['home', *postures])}")
        return self._standing(postures[name])

    def center_of_mass(self, q: Vector) -> Vector:
        """Compute the centre of mass of a configuration, shape (3,) [m], world frame."""
        return np.array(pinocchio.centerOfMass(self.model, self.model.createData(), q))

    @cached_property
    def home_com(self) -> Vector:
        """Centre of mass at home, shape (3,) [m], world frame."""
        return self.center_of_mass(self.home.q)

    @cached_property
    def home_inertia(self) -> float:
        """Mean moment of inertia about the centre of mass, at home [kg m^2]."""
        data = self.model.createData()
        pinocchio.ccrba(self.model, data, self.home.q, self.home.v)
        return float(np.trace(data.Ig.inertia)) / 3.0

    def sole_placements(self, q: Vector) -> list[Any]:
        """Compute where the soles are.

        Args:
            q: Configuration, shape (nq,).

        Returns:
            ``pinocchio.SE3`` of each contact's frame in the world, copies, in
            the order of the robot file.
        """
        data = self.model.createData()
        pinocchio.framesForwardKinematics(self.model, data, q)
        return [data.oMf[frame].copy() for frame in self.sole_frames]

    @cached_property
    def sole_frames(self) -> list[int]:
        """Pinocchio's index of each contact's frame."""
        return [self.frame_id(contact.name) for contact in self.description.contacts]

    def frame_name(self, part: str) -> str:
        """Name the frame of a contact or a frame task in ``model``.

        Args:
            part: Name of the contact or task.
        """
        return self.bodies.frame_names[part]

    def frame_id(self, part: str) -> int:
        """Find the frame of a contact or a frame task.

        Args:
            part: Name of the contact or task.

        Returns:
            Its index in ``model.frames``.
        """
        return int(self.model.getFrameId(self.frame_name(part)))

    @cached_property
    def feet(self) -> list[Foot]:
        """What each contact keeps in its place, in the order of the robot file."""
        contacts = zip(self.description.contacts, self.sole_frames, strict=True)
        return [make_foot(contact, frame) for contact, frame in contacts]

    def axis_for(self, motion: str, kind: str, axis: str, prefer: str = "") -> str:
        """Find the axis 'task.axis' that carries a motion.

        Args:
            motion: Name of the motion; the robot file may name its task.
            kind: 'com' or 'frame'.
            axis: Name of the axis in its task.
            prefer: Name of the task to take if there are several; else the first.

        Raises:
            InvalidValue: If no task of that kind has the axis.
        """
        tasks = {part.name: part for part in self.description.tasks}
        able = [name for name, part in tasks.items() if part.type == kind and axis in part.axes]
        part = self.description.motions.get(motion)
        wanted = None if part is None else part.task
        if wanted in able:
            return f"{wanted}.{axis}"
        if wanted is not None or not able:
            known = ", ".join(f"{name} ({' '.join(part.axes)})" for name, part in tasks.items())
            raise InvalidValue(
                f"the task of {motion}",
                str(wanted),
                f"a {kind} task with axis {axis} among {known}",
            )
        return f"{prefer if prefer in able else able[0]}.{axis}"

    def put_on_ground(self, q: Vector) -> Vector:
        """Raise or lower a configuration until its soles are at z = 0 on average.

        Args:
            q: Configuration, shape (nq,).

        Returns:
            A changed copy, shape (nq,).
        """
        grounded = q.copy()
        soles = self.sole_placements(q)
        grounded[2] -= np.mean([sole.translation[2] for sole in soles])
        return grounded

    def _standing(self, joints: dict[str, float]) -> State:
        q = pinocchio.neutral(self.model)
        turned = pinocchio.rpy.rpyToMatrix(*self.description.base_orientation)
        q[3:7] = pinocchio.Quaternion(turned).coeffs()
        for joint, angle in joints.items():
            q[self.model.joints[self.model.getJointId(joint)].idx_q] = angle
        return State(q=self.put_on_ground(q), v=np.zeros(self.nv))

    def frame_placement(self, frame: str, q: Vector) -> tuple[Vector, Vector]:
        """Compute where a frame is.

        Args:
            frame: Name of a frame of ``model``.
            q: Configuration, shape (nq,).

        Returns:
            Position [m] and orientation as a quaternion xyzw, world frame.
        """
        data = self.model.createData()
        pinocchio.framesForwardKinematics(self.model, data, q)
        placement = data.oMf[self.model.getFrameId(frame)]
        quaternion = pinocchio.Quaternion(placement.rotation).coeffs()
        return np.array(placement.translation), np.array(quaternion)


def _velocity_limit(model: Any) -> Vector:
    """Read velocity limits; descriptions write 0 where they know none."""
    limit = np.array(model.upperVelocityLimit[6:])
    return np.where(limit > 0, limit, np.inf)


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
    path = Path(os.path.expanduser(robot))
    if not os.path.isfile(path):
        raise UnknownRobot(str(robot), list(shipped))
    return Robot(path)
