"""The two feet that a user names."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.exceptions.did_you_mean import nearest
from tsd_casadi.proposal.body import Body
from tsd_casadi.robot.rigid_body_model import RigidBodyModel


def find_foot(bodies: RigidBodyModel, source: Path, foot: str) -> int:
    """Find a foot by its name.

    Returns:
        Index of its frame.

    Raises:
        RobotFileError: If there is none; it names the nearest.
    """
    index = bodies.find_frame(foot)
    if index is None:
        names = [frame.name for frame in list(bodies.model.frames)[2:]]
        raise RobotFileError(
            source, "--feet", f"'{foot}' is no link or frame", nearest(foot, names)
        )
    return index


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


def describe_soles(body: Body, feet: tuple[str, str]) -> list[str]:
    """Say what was found under the feet, a line each."""
    notes = []
    for side, foot, sole in zip(("left", "right"), feet, body.soles, strict=True):
        size = f"{1e3 * np.ptp(sole.x):.0f} mm x {1e3 * np.ptp(sole.y):.0f} mm"
        where = f"at frame {sole.frame}" if sole.is_frame else f"under {sole.frame}"
        notes.append(f"{side} sole: {size} {where}, from its {sole.source} geometry")
        if sole.source == "visual":
            notes.append(f"{foot} has no flat collision geometry: what is drawn was taken")
        if 2e-3 < abs(sole.named_height) < 0.02 and sole.frame == foot and not sole.is_frame:
            notes.append(f"{foot} is {1e3 * sole.named_height:.1f} mm above its lowest flat patch")
    heel, toe = (abs(float(extent)) for extent in body.soles[0].from_ankle)
    if heel > 1.2 * toe:
        notes.append("the heels are longer than the toes: is LEFT really the left foot?")
    return notes
