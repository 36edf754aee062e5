"""The two feet that a user names."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.exceptions.did_you_mean import nearest
from tsd_casadi.robot.rigid_body_model import RigidBodyModel

# a leg with fewer joints cannot place a sole flat
LEAST_JOINTS = 3


def find_foot(bodies: RigidBodyModel, source: Path, foot: str) -> int:
    """Find a foot by its name.

    Returns:
        Index of its frame.

    Raises:
        RobotFileError: If there is none; it names the ends of the legs, and the nearest.
    """
    index = bodies.find_frame(foot)
    if index is None:
        names = [frame.name for frame in list(bodies.model.frames)[2:]]
        raise RobotFileError(
            source,
            "--feet",
            f"'{foot}' is no link or frame" + name_legs(bodies.model),
            nearest(foot, names),
        )
    return index


def check_legs(bodies: RigidBodyModel, path: Path, feet: tuple[str, str]) -> None:
    """Refuse feet at the ends of arms.

    Arms are lighter than legs, and the middle between hands is nearer to the centre of
    mass than that between feet; which way is up is not known yet.

    Raises:
        RobotFileError: If two other chains are both heavier and reach further; it names
            their ends.
    """
    model, data = bodies.model, bodies.model.createData()
    q = pinocchio.neutral(model)
    com = pinocchio.centerOfMass(model, data, q)
    joints = [model.frames[find_foot(bodies, path, foot)].parentJoint for foot in feet]
    legs = _heaviest_ends(model)
    chains = {j for leg in legs for j in list(model.supports[leg])} - {0, 1}
    if len(legs) < 2 or 1 in joints or chains & set(joints):
        return

    def reach(pair: Sequence[int]) -> float:
        middle = 0.5 * (data.oMi[pair[0]].translation + data.oMi[pair[1]].translation)
        return float(np.linalg.norm(middle - com))

    if reach(legs) > reach(joints):
        leftwards = data.oMi[joints[0]].translation - data.oMi[joints[1]].translation
        names = _names(model, legs, leftwards)
        raise RobotFileError(
            path,
            "--feet",
            f"{feet[0]} and {feet[1]} are at the ends of arms: {names} end heavier chains "
            "that reach further",
            f"the last links of both legs, perhaps --feet {names.replace(' and ', ',')}",
        )


def check_feet(model: Any, path: Path, feet: tuple[str, str], joints: Sequence[int]) -> None:
    """Refuse what carries no weight, or is above a joint of the leg.

    Args:
        joints: Indices of the joints that carry the feet.

    Raises:
        RobotFileError: If a foot is a part of the base, has a joint below it, or is
            the other one.
    """
    for foot, joint in zip(feet, joints, strict=True):
        below = [str(model.names[j]) for j in range(2, model.njoints) if model.parents[j] == joint]
        if joint < 2:
            raise RobotFileError(
                path, "--feet", f"{foot} is a part of the base", "the last links of both legs"
            )
        if below:
            raise RobotFileError(
                path,
                "--feet",
                f"{foot} is no foot: {', '.join(below)} moves what is below it",
                "the last link of the leg, or a locked toe: "
                + " ".join(f"--lock {name}" for name in below),
            )
    if joints[0] == joints[1]:
        raise RobotFileError(path, "--feet", "are one and the same body", "two that move apart")


def name_legs(model: Any) -> str:
    """Tell in which links the legs seem to end, behind what was found.

    Args:
        model: ``pinocchio.Model`` with a free-flyer.
    """
    legs = _heaviest_ends(model)
    return f"; the legs seem to end in {_names(model, legs)}" if len(legs) == 2 else ""


def _heaviest_ends(model: Any) -> list[int]:
    """Find the last joints of the two heaviest chains without branches, the legs' probably."""
    data = model.createData()
    pinocchio.computeSubtreeMasses(model, data)
    parents = list(model.parents)
    chains = {}
    for end in range(2, model.njoints):
        if end in parents or len(list(model.supports[end])) - 2 < LEAST_JOINTS:
            continue
        first = end
        while parents[first] > 1 and parents.count(parents[first]) == 1:
            first = parents[first]
        chains[end] = float(data.mass[first])
    return sorted(chains, key=lambda end: -chains[end])[:2]


def _names(model: Any, joints: Sequence[int], leftwards: Sequence[float] = (0.0, 1.0, 0.0)) -> str:
    """Name the links of two joints, the left one first.

    Args:
        leftwards: Direction in the base's frame, (3,).
    """
    data = model.createData()
    pinocchio.forwardKinematics(model, data, pinocchio.neutral(model))
    ordered = sorted(joints, key=lambda j: -float(data.oMi[j].translation @ np.array(leftwards)))
    links = {
        frame.parentJoint: str(frame.name)
        for frame in reversed(list(model.frames))
        if frame.type == pinocchio.FrameType.BODY
    }
    return " and ".join(links[j] for j in ordered)
