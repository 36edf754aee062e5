"""The soles of the two feet that a user names, and what is to be told of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.robot.geometry import Use, load_geometry
from tsd_casadi.robot.rigid_body_model import RigidBodyModel
from tsd_casadi.robot.sole_patch import SolePatch, find_sole_patch
from tsd_casadi.state import Vector

# of the length and width of a patch: the edge is where contact is lost
INSIDE = 0.9
# left and right soles are mirrored copies: what differs by more was measured in something
# else, such as one foot's collision mesh and the other's drawing [m]
UNEQUAL = 3e-3
# heels this many times as long as the toes are a reason to ask; beyond the second, the feet
# have changed places: a foot in the right order has toes as long as the heel at least
LONG_HEELS, SWAPPED = 1.2, 1.5

Soles = tuple[SolePatch, SolePatch]


def find_soles(
    bodies: RigidBodyModel, path: Path, frames: Sequence[int], q: Vector
) -> tuple[Soles, tuple[str, ...]]:
    """Find the flat patches of both feet.

    Args:
        path: The description, for errors.
        frames: Indices of the left and of the right foot.
        q: Configuration that is upright, (nq,).

    Returns:
        Left and right, and the meshes of the feet that are not there.

    Raises:
        RobotFileError: If a foot has no flat patch.
    """
    model = bodies.model
    joints = [model.frames[frame].parentJoint for frame in frames]
    shapes, missing = _shapes_of(bodies, joints)
    left, right = (find_sole_patch(path, model, shapes, frame, q, missing) for frame in frames)
    return (left, right), missing


def inside(sole: SolePatch) -> SolePatch:
    """Shrink a sole to what the controller counts on."""
    shrunk = [
        (
            0.5 * (low + high) - 0.5 * INSIDE * (high - low),
            0.5 * (low + high) + 0.5 * INSIDE * (high - low),
        )
        for low, high in (sole.x, sole.y)
    ]
    return dataclasses.replace(sole, x=shrunk[0], y=shrunk[1])


def describe_soles(soles: Soles, feet: tuple[str, str], missing: Sequence[str]) -> list[str]:
    """Say what was found under the feet, a line each.

    Args:
        soles: The patches as they are.
        feet: What the user calls them.
        missing: Meshes of the feet that are not there.
    """
    notes = []
    if missing:
        notes.append(f"meshes of the feet that are NOT THERE: {', '.join(missing)}")
    for side, foot, sole in zip(("left", "right"), feet, soles, strict=True):
        patch, counted = (_size(each) for each in (sole, inside(sole)))
        where = f"at frame {sole.frame}" if sole.is_frame else f"under {sole.frame}"
        notes.append(
            f"{side} sole: flat over {patch} {where}, from its {sole.source} geometry; "
            f"the file has {INSIDE:g} of it, {counted}"
        )
        if sole.source == "visual":
            notes.append(f"{foot} has no flat collision geometry: what is drawn was taken")
        if 2e-3 < abs(sole.named_height) < 0.02 and sole.frame == foot and not sole.is_frame:
            notes.append(f"{foot} is {1e3 * sole.named_height:.1f} mm above its lowest flat patch")
    left, right = (np.array([np.ptp(sole.x), np.ptp(sole.y), *sole.from_ankle]) for sole in soles)
    difference = float(np.max(np.abs(left - right)))
    if difference > UNEQUAL:
        notes.append(
            f"the soles differ by {1e3 * difference:.0f} mm, left from right: look at the "
            "geometry of both feet"
        )
    return notes


def long_heels(soles: Soles) -> list[str]:
    """Ask whether the feet have changed places, where the heels are longer than the toes."""
    if LONG_HEELS < _heels(soles) <= SWAPPED:
        return ["the heels are longer than the toes: is LEFT really the left foot?"]
    return []


def swapped_feet(soles: Soles, feet: tuple[str, str]) -> list[str]:
    """Say that the feet have changed places, where the heels are far longer than the toes."""
    ratio = _heels(soles)
    if ratio <= SWAPPED:
        return []
    return [
        f"the heels are {ratio:.1f} times as long as the toes: is LEFT really the left foot? "
        f"The other way round it is --feet {feet[1]},{feet[0]}"
    ]


def _heels(soles: Soles) -> float:
    """Compute the length of the left heel in shares of the toes."""
    heel, toe = (abs(float(extent)) for extent in soles[0].from_ankle)
    return heel / max(toe, 1e-3)


def _size(sole: SolePatch) -> str:
    return f"{1e3 * np.ptp(sole.x):.0f} mm x {1e3 * np.ptp(sole.y):.0f} mm"


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
    return shapes, tuple(dict.fromkeys((*collision.missing, *visual.missing)))
