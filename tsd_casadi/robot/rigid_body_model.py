"""From a robot file and its description to Pinocchio's model of rigid bodies."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.exceptions.did_you_mean import nearest
from tsd_casadi.robot.description import Description
from tsd_casadi.robot.description_changes import complete_joints, override_links
from tsd_casadi.robot.joint_patterns import values_by_joint
from tsd_casadi.robot.parsed_model import parse_model
from tsd_casadi.robot.robot_file import RobotFile
from tsd_casadi.robot.robot_file_sections import Contact, PointFile, SoleFile
from tsd_casadi.robot.robot_file_tasks import FrameTaskFile

# sections of the robot file that are by joint
BY_JOINT = ("locked", "effort", "velocity", "position")


class RigidBodyModel:
    """The bodies that move, and the frames that contacts and tasks are about.

    Attributes:
        model: ``pinocchio.Model`` with a free-flyer base; locked joints are gone,
            their links are parts of the bodies that carry them.
        full: The same with the locked joints, for what has to be reduced alike.
        locked: Indices of the locked joints in ``full``.
        locked_at: Configuration of ``full`` with the locked joints' angles.
        description: Links and joints, with what the robot file overrides.
        frame_names: Name of the frame of each contact and frame task in ``model``.
    """

    def __init__(self, path: Path, file: RobotFile, description: Description) -> None:
        """Build the model.

        Args:
            path: The robot file, for errors.
            file: Its content.
            description: Links and joints; gets what the robot file overrides.

        Raises:
            RobotFileError: If the description cannot be used, or lacks what the
                robot file names.
        """
        self._path, self.description = path, description
        moving = [n for n, j in description.joints().items() if j.get("type") != "fixed"]
        values: dict[str, dict[str, Any]] = {
            field: values_by_joint(path, field, getattr(file, field), moving) for field in BY_JOINT
        }
        override_links(description, path, file.links)
        if description.kind == "urdf":
            given = {field: values[field].keys() for field in BY_JOINT}
            complete_joints(description, path, values["locked"].keys(), given)
        self.full = parse_model(description)
        self._set_limits(values)
        self.locked = [self.full.getJointId(name) for name in values["locked"]]
        self.locked_at = self._locked_at(values["locked"])
        self.model = pinocchio.buildReducedModel(self.full, self.locked, self.locked_at)
        self._check_joints()
        self.frame_names = {
            part.name: self._frame_of(part, f"{kind}.{index}")
            for kind, parts in (("contacts", file.contacts), ("tasks", file.all_tasks))
            for index, part in enumerate(parts)
            if isinstance(part, (FrameTaskFile, SoleFile, PointFile))
        }

    def find_frame(self, name: str) -> int | None:
        """Find a link or frame, the link where a joint has the same name.

        Returns:
            Its index in ``model.frames``, None if there is none.
        """
        found = [
            index
            for index, frame in enumerate(self.model.frames)
            if frame.name == name and index > 0
        ]
        links = [i for i in found if self.model.frames[i].type == pinocchio.FrameType.BODY]
        return next(iter(links or found), None)

    def link_of(self, joint: int) -> str:
        """Name the link that a joint of ``model`` moves; others may be fixed to it."""
        return next(
            str(frame.name)
            for frame in self.model.frames
            if frame.parentJoint == joint and frame.type == pinocchio.FrameType.BODY
        )

    def _set_limits(self, values: Mapping[str, Mapping[str, Any]]) -> None:
        model = self.full
        for field, limit in (("effort", "EffortLimit"), ("velocity", "VelocityLimit")):
            for joint, value in values[field].items():
                place = self._single(joint).idx_v
                getattr(model, f"lower{limit}")[place] = -value
                getattr(model, f"upper{limit}")[place] = value
        for joint, (low, high) in values["position"].items():
            place = self._single(joint).idx_q
            model.lowerPositionLimit[place], model.upperPositionLimit[place] = low, high

    def _single(self, joint: str) -> Any:
        found = self.full.joints[self.full.getJointId(joint)]
        if found.nq != 1:
            raise RobotFileError(
                self._path, joint, f"is a {found.shortname()}", "a joint with one angle"
            )
        return found

    def _locked_at(self, locked: Mapping[str, float]) -> Any:
        q = pinocchio.neutral(self.full)
        for name, angle in locked.items():
            joint = self.full.joints[self.full.getJointId(name)]
            if joint.nq != 1:
                if angle:
                    raise RobotFileError(
                        self._path,
                        f"locked.{name}",
                        f"is {angle:g} for a {joint.shortname().removeprefix('JointModel')} joint",
                        "0, its middle, where it has more than one coordinate",
                    )
                continue
            low, high = (
                float(limit[joint.idx_q])
                for limit in (self.full.lowerPositionLimit, self.full.upperPositionLimit)
            )
            if not low <= angle <= high:
                raise RobotFileError(
                    self._path,
                    f"locked.{name}",
                    f"is {angle:g} rad",
                    f"a value from {low:g} to {high:g} rad",
                )
            q[joint.idx_q] = angle
        return q

    def _check_joints(self) -> None:
        model, file = self.model, self._path.name
        for name, joint in zip(list(model.names)[2:], list(model.joints)[2:], strict=True):
            leader = self.description.leader_of(name)
            if leader is not None:
                raise self._error(
                    f"joint {name} mimics {leader}",
                    f"it not to move by itself: in {file}, 'locked: {{{name}: 0.0}}'",
                )
            if (joint.nq, joint.nv) != (1, 1):
                kind = joint.shortname().removeprefix("JointModel")
                raise self._error(
                    f"joint {name} is of the type {kind}, with {joint.nv} degrees of freedom"
                    if joint.nv > 1
                    else f"joint {name} turns without end",
                    "revolute and prismatic joints with limits; lock it, "
                    f"'locked: {{{name}: 0.0}}' in {file}",
                )
            low, high = model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]
            if not low < high:
                raise self._error(
                    f"joint {name} has limits from {low:g} to {high:g} rad",
                    f"the low value first, here or in {file}: 'position: {{{name}: [low, high]}}'",
                )

    def _frame_of(self, part: Contact | FrameTaskFile, field: str) -> str:
        """Find the frame of a contact or task, or add it, under a name that is its own."""
        name = part.frame
        index = self.find_frame(name)
        if index is None:
            names = [frame.name for frame in list(self.model.frames)[1:]]
            raise RobotFileError(
                self._path,
                f"{field}.frame",
                f"'{name}' is no link or frame of {self.description.path.name}",
                nearest(name, names),
            )
        offset = None if isinstance(part, FrameTaskFile) else part.offset
        alone = [frame.name for frame in self.model.frames].count(name) == 1
        if offset is None and alone:
            return str(name)
        frame = self.model.frames[index]
        placement = pinocchio.SE3.Identity()
        if offset is not None:
            placement = pinocchio.SE3(
                pinocchio.rpy.rpyToMatrix(*offset.rpy), np.array(offset.xyz, dtype=float)
            )
        own = f"{name}/{part.name}"
        self.model.addFrame(
            pinocchio.Frame(
                own,
                frame.parentJoint,
                index,
                frame.placement * placement,
                pinocchio.FrameType.OP_FRAME,
            )
        )
        return own

    def _error(self, found: str, expected: str) -> RobotFileError:
        return RobotFileError(self.description.path, "", found, expected)
