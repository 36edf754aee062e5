"""The two feet that a user names."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pinocchio

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.exceptions.did_you_mean import nearest
from tsd_casadi.robot.rigid_body_model import RigidBodyModel
from tsd_casadi.state import Vector

# a leg with fewer joints cannot place a sole flat
LEAST_JOINTS = 3
# of the robot's height: hands that hang lower than bent legs do so by less
HIGHER = 0.15


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
        model = bodies.model
        ends = _ends(bodies, pinocchio.neutral(model))[:2]
        # seen from a base whose axes are not upright these may be others: hence both
        legs = f"the lowest ends of chains are {_names(bodies, ends)}; " if len(ends) == 2 else ""
        raise RobotFileError(
            source, "--feet", f"'{foot}' is no link or frame", legs + nearest(foot, names)
        )
    return index


def check_lowest(
    bodies: RigidBodyModel,
    path: Path,
    feet: tuple[str, str],
    joints: Sequence[int],
    q: Vector,
) -> None:
    """Refuse feet above two other ends of chains, such as hands.

    Args:
        joints: Indices of the joints that carry the feet.
        q: Configuration that is upright, (nq,).

    Raises:
        RobotFileError: If both are; it names the other two.
    """
    heights = _heights(bodies.model, q)
    lowest = min(heights[j] for j in joints)
    margin = HIGHER * (max(heights.values()) - min(heights.values()))
    below = [j for j in _ends(bodies, q) if j not in joints and heights[j] < lowest - margin]
    if len(below) < 2:
        return
    legs = _names(bodies, below[:2])
    raise RobotFileError(
        path,
        "--feet",
        f"{feet[0]} and {feet[1]} end arms rather than legs, {legs} are lower by "
        f"{lowest - max(heights[j] for j in below[:2]):.2f} m",
        f"the lowest links, perhaps --feet {legs.replace(' and ', ',')}",
    )


def _ends(bodies: RigidBodyModel, q: Vector) -> list[int]:
    """List the last joints of chains as long as legs, the lowest first."""
    model = bodies.model
    parents = set(model.parents)
    heights = _heights(model, q)
    ends = [
        j
        for j in range(2, model.njoints)
        if j not in parents and len(list(model.supports[j])) - 2 >= LEAST_JOINTS
    ]
    return sorted(ends, key=lambda j: heights[j])


def _names(bodies: RigidBodyModel, joints: Sequence[int]) -> str:
    """Name the links of two joints, the left one first where x is ahead."""
    model, data = bodies.model, bodies.model.createData()
    pinocchio.forwardKinematics(model, data, pinocchio.neutral(model))
    return " and ".join(
        bodies.link_of(j) for j in sorted(joints, key=lambda j: -float(data.oMi[j].translation[1]))
    )


def _heights(model: Any, q: Vector) -> dict[int, float]:
    """Compute how high the joints are, by index [m]."""
    data = model.createData()
    pinocchio.forwardKinematics(model, data, q)
    return {j: float(data.oMi[j].translation[2]) for j in range(1, model.njoints)}


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
