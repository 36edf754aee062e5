"""From a description and two feet to the body that a file is proposed for."""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.proposal.arms import body_height
from tsd_casadi.proposal.body import Body, upright_neutral
from tsd_casadi.proposal.efforts import known_limits
from tsd_casadi.proposal.feet import check_feet, describe_soles, find_foot
from tsd_casadi.proposal.locks import (
    Locks,
    lock_followers,
    lock_unmovable,
    named_locks,
    settle_angles,
    suggest,
)
from tsd_casadi.proposal.masses import Moments, mend_inertias
from tsd_casadi.proposal.upright import find_upright
from tsd_casadi.robot.description import CONTINUOUS, Description, kind_of, read_description
from tsd_casadi.robot.geometry import Use, load_geometry
from tsd_casadi.robot.rigid_body_model import RigidBodyModel
from tsd_casadi.robot.robot_file import RobotFile
from tsd_casadi.robot.robot_file_overrides import LinkFile
from tsd_casadi.robot.sole_patch import SolePatch, find_sole_patch

# of the length and width of a patch: the edge is where contact is lost
INSIDE = 0.9
# of a joint that turns without end: it has to have limits, and half a turn is far
HALF_TURN = 3.1415


@dataclass(frozen=True)
class Survey:
    """What a description is, with what has to be changed to work with it.

    Attributes:
        description: Links and joints.
        bodies: How its model was made.
        body: With soles.
        locks: Joints that do not move.
        position: Limits of continuous joints [rad].
        moments: Inertias by link, where those of the description cannot be.
        notes: What was found and assumed, a line each.
    """

    description: Description
    bodies: RigidBodyModel
    body: Body
    locks: Locks
    position: dict[str, tuple[float, float]]
    moments: Moments
    notes: list[str]


def survey(source: Path, feet: tuple[str, str], patterns: Sequence[str]) -> Survey:
    """Read a description and find what a robot file has to say about it.

    Args:
        source: URDF, xacro or MJCF.
        feet: Names of the left and of the right foot: links, or frames on them.
        patterns: Joints to lock, names or regular expressions.

    Raises:
        RobotFileError: If the description cannot be used as it is.
    """
    description = read_description(source, kind_of(source))
    moving = [name for name, j in description.joints().items() if j.get("type") != "fixed"]
    locks = named_locks(source, moving, patterns)
    lock_followers(locks, description, moving)
    position = {
        name: (-HALF_TURN, HALF_TURN)
        for name, joint in description.joints().items()
        if joint.get("type") == CONTINUOUS and name not in locks.angles
    }
    settle_angles(locks, description)
    bodies = _bodies(description, locks, position, {})
    frames = tuple(find_foot(bodies, source, foot) for foot in feet)
    legs = _leg_joints(bodies.model, frames)
    lock_unmovable(locks, source, bodies.full, legs)
    settle_angles(locks, read_description(source, description.kind))
    moments = mend_inertias(bodies)
    description = read_description(source, description.kind)
    bodies = _bodies(description, locks, position, moments)
    notes = [*locks.notes, *suggest(bodies.model, legs)]
    if position:
        notes.append(f"turn without end, get limits of half a turn: {', '.join(position)}")
    if moments:
        notes.append(f"inertias that no body can have are replaced: {', '.join(moments)}")
    body = _stand_up(description, bodies, feet)
    notes += describe_soles(body, feet)
    return Survey(description, bodies, body, locks, position, moments, notes)


def _bodies(
    description: Description, locks: Locks, position: dict[str, Any], moments: Moments
) -> RigidBodyModel:
    links = {link: LinkFile(inertia=values) for link, values in moments.items()}
    draft = RobotFile.model_construct(
        locked=locks.angles, position=position, links=links, contacts=(), tasks=()
    )
    # a file that is not there yet, for errors that name what is in it
    return RigidBodyModel(Path(tempfile.gettempdir()) / "robot.yaml", draft, description)


def _leg_joints(model: Any, frames: Sequence[int]) -> set[str]:
    joints = {j for frame in frames for j in list(model.supports[model.frames[frame].parentJoint])}
    return {str(model.names[j]) for j in joints - {0, 1}}


def _stand_up(description: Description, bodies: RigidBodyModel, feet: tuple[str, str]) -> Body:
    model, path = bodies.model, description.path
    frames = [find_foot(bodies, path, foot) for foot in feet]
    joints = [model.frames[frame].parentJoint for frame in frames]
    check_feet(model, path, feet, joints)
    upright = find_upright(path, model, (frames[0], frames[1]))
    q = upright_neutral(model, upright)
    geometry, missing = _shapes_of(bodies, joints)
    left, right = (find_sole_patch(path, model, geometry, frame, q, missing) for frame in frames)
    sole_frames = tuple(
        _add_frame(model, f"{side} sole of a proposal", sole)
        for side, sole in (("left", left), ("right", right))
    )
    both = (sole_frames[0], sole_frames[1])
    body = Body(model, upright, (_inside(left), _inside(right)), both, np.ones(model.nv - 6))
    moment = body.mass * 9.81 * body_height(body, q)
    return dataclasses.replace(body, limit=known_limits(model, moment))


def _shapes_of(
    bodies: RigidBodyModel, joints: Sequence[int]
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Load the shapes of what some joints carry, and list the meshes that are not there."""
    links = [
        str(frame.name)
        for frame in bodies.model.frames
        if frame.parentJoint in joints and frame.type == pinocchio.FrameType.BODY
    ]
    uses: tuple[Use, Use] = ("collision", "visual")
    collision, visual = (load_geometry(bodies, use, links) for use in uses)
    shapes = {"collision": collision.model, "visual": visual.model}
    return shapes, (*collision.missing, *visual.missing)


def _inside(sole: SolePatch) -> SolePatch:
    """Shrink a sole to what the controller counts on."""
    shrunk = [
        (
            0.5 * (low + high) - 0.5 * INSIDE * (high - low),
            0.5 * (low + high) + 0.5 * INSIDE * (high - low),
        )
        for low, high in (sole.x, sole.y)
    ]
    return dataclasses.replace(sole, x=shrunk[0], y=shrunk[1])


def _add_frame(model: Any, name: str, sole: SolePatch) -> int:
    frame = model.frames[sole.index]
    kind = pinocchio.FrameType.OP_FRAME
    placement = frame.placement * sole.placement
    return int(
        model.addFrame(pinocchio.Frame(name, frame.parentJoint, sole.index, placement, kind))
    )
