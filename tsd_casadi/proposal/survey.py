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
from tsd_casadi.proposal.feet import check_feet, check_legs, find_foot
from tsd_casadi.proposal.joints import check_followers, check_joints, fill_efforts, odd_limits
from tsd_casadi.proposal.locks import (
    Locks,
    lock_followers,
    lock_unmovable,
    named_locks,
    settle_angles,
    suggest,
)
from tsd_casadi.proposal.masses import (
    Moments,
    check_carried,
    check_masses,
    heavy_links,
    mend_inertias,
)
from tsd_casadi.proposal.soles import (
    Soles,
    describe_soles,
    find_soles,
    inside,
    long_heels,
    swapped_feet,
)
from tsd_casadi.proposal.upright import find_upright
from tsd_casadi.robot.description import CONTINUOUS, Description, Kind, kind_of, read_description
from tsd_casadi.robot.rigid_body_model import RigidBodyModel
from tsd_casadi.robot.robot_file import RobotFile
from tsd_casadi.robot.robot_file_overrides import LinkFile
from tsd_casadi.robot.sole_patch import SolePatch

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
        suspicions: Numbers of the description that nobody can have meant, a line each.
        mistakes: What was named wrongly almost for certain, a line each.
    """

    description: Description
    bodies: RigidBodyModel
    body: Body
    locks: Locks
    position: dict[str, tuple[float, float]]
    moments: Moments
    notes: list[str]
    suspicions: list[str]
    mistakes: list[str]


def survey(source: Path, feet: tuple[str, str], patterns: Sequence[str]) -> Survey:
    """Read a description and find what a robot file has to say about it.

    Args:
        source: URDF, xacro or MJCF.
        feet: Names of the left and of the right foot: links, or frames on them.
        patterns: Joints to lock, names or regular expressions.

    Raises:
        RobotFileError: If the description cannot be used as it is.
    """
    kind = kind_of(source)
    description = _read(source, kind)
    check_masses(description)
    moving = [name for name, j in description.joints().items() if j.get("type") != "fixed"]
    locks = named_locks(source, moving, patterns)
    named = set(locks.angles)
    lock_followers(locks, description, moving)
    check_joints(description, locks.angles)
    position = {
        name: (-HALF_TURN, HALF_TURN)
        for name, joint in description.joints().items()
        if joint.get("type") == CONTINUOUS and name not in locks.angles
    }
    settle_angles(locks, description)
    bodies = _bodies(description, locks, position, {})
    check_followers(description, bodies.full, feet, named)
    frames = tuple(find_foot(bodies, source, foot) for foot in feet)
    legs = _leg_joints(bodies.model, frames)
    check_carried(source, bodies.full, sorted(legs))
    lock_unmovable(locks, source, bodies.full, legs)
    settle_angles(locks, _read(source, kind))
    moments = mend_inertias(bodies)
    description = _read(source, kind)
    bodies = _bodies(description, locks, position, moments)
    suspicions = [*heavy_links(bodies), *odd_limits(bodies.model)]
    notes = [*locks.notes, *suggest(bodies.model, legs)]
    if position:
        notes.append(f"turn without end, get limits of half a turn: {', '.join(position)}")
    if moments:
        notes.append(f"inertias that no body can have are replaced: {', '.join(moments)}")
    body, soles, missing = _stand_up(description, bodies, feet)
    notes += describe_soles(soles, feet, missing)
    suspicions += long_heels(soles)
    mistakes = swapped_feet(soles, feet)
    return Survey(description, bodies, body, locks, position, moments, notes, suspicions, mistakes)


def _read(source: Path, kind: Kind) -> Description:
    description = read_description(source, kind)
    fill_efforts(description)
    return description


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


def _stand_up(
    description: Description, bodies: RigidBodyModel, feet: tuple[str, str]
) -> tuple[Body, Soles, tuple[str, ...]]:
    """Find the body, the whole patches of its soles, and their meshes that are missing."""
    model, path = bodies.model, description.path
    frames = [find_foot(bodies, path, foot) for foot in feet]
    joints = [model.frames[frame].parentJoint for frame in frames]
    check_legs(bodies, path, feet)
    check_feet(model, path, feet, joints)
    upright = find_upright(path, model, (frames[0], frames[1]))
    q = upright_neutral(model, upright)
    soles, missing = find_soles(bodies, path, frames, q)
    sole_frames = tuple(
        _add_frame(model, f"{side} sole of a proposal", sole)
        for side, sole in zip(("left", "right"), soles, strict=True)
    )
    both = (sole_frames[0], sole_frames[1])
    counted = (inside(soles[0]), inside(soles[1]))
    body = Body(model, upright, counted, both, np.ones(model.nv - 6))
    moment = body.mass * 9.81 * body_height(body, q)
    return dataclasses.replace(body, limit=known_limits(model, moment)), soles, missing


def _add_frame(model: Any, name: str, sole: SolePatch) -> int:
    frame = model.frames[sole.index]
    kind = pinocchio.FrameType.OP_FRAME
    placement = frame.placement * sole.placement
    return int(
        model.addFrame(pinocchio.Frame(name, frame.parentJoint, sole.index, placement, kind))
    )
