"""Whether the soles of the robot file are where the feet are flat."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.examination.finding import Finding
from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.geometry import load_geometry
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import SoleFile
from tsd_casadi.robot.sole_patch import SolePatch, find_sole_patch

# what a drawn sole may be off the ground, chamfers and mesh tolerances [m]
HEIGHT = 2e-3
# feet are lower than their ankles by at least this: what is so far up is no sole [m]
ANKLE = 0.03
# a flat patch is found with its normal to a hundredth of this, facets of a mesh to it [rad]
TILT = 0.02


def contact_soles(robot: Robot) -> Iterator[Finding]:
    """Compare each sole with the lowest flat patch of its foot's geometry."""
    places = robot.sole_placements(robot.home.q)
    for index, (contact, place) in enumerate(zip(robot.description.contacts, places, strict=True)):
        if not isinstance(contact, SoleFile):
            continue
        element = f"contact {contact.name}"
        try:
            patch = _patch_of(robot, robot.sole_frames[index])
        except RobotFileError as error:
            yield Finding(
                "note",
                element,
                f"cannot be compared with the foot: {error}",
                "look at the picture of home",
            )
            continue
        # from the sole of the robot file to the patch
        yield from _compare(contact, place.actInv(_in_world(robot, patch)), patch, element)


def _patch_of(robot: Robot, frame: int) -> SolePatch:
    bodies, joint = robot.bodies, robot.model.frames[frame].parentJoint
    links = [
        each.name
        for each in robot.model.frames
        if each.parentJoint == joint and each.type == pinocchio.FrameType.BODY
    ]
    geometries = {use: load_geometry(bodies, use, links).model for use in ("collision", "visual")}
    return find_sole_patch(robot.source_path, robot.model, geometries, frame, robot.home.q)


def _in_world(robot: Robot, patch: SolePatch) -> Any:
    data = robot.model.createData()
    pinocchio.framesForwardKinematics(robot.model, data, robot.home.q)
    return data.oMf[patch.index] * patch.placement


def _compare(contact: SoleFile, offset: Any, patch: SolePatch, element: str) -> Iterator[Finding]:
    height = -float(offset.translation[2])
    write = f"'offset' of the contact {1e3 * height:.1f} mm lower"
    if height > ANKLE:
        yield Finding(
            "error",
            element,
            f"is {1e3 * height:.0f} mm above the lowest part of its foot, as an ankle is",
            f"the sole: {write}",
        )
    elif abs(height) > HEIGHT:
        where = "above" if height > 0 else "below"
        yield Finding(
            "error",
            element,
            f"is {1e3 * abs(height):.1f} mm {where} the lowest part of its foot",
            write if height > 0 else f"'offset' of the contact {-1e3 * height:.1f} mm higher",
        )
    tilt = float(np.arccos(np.clip(offset.rotation[2, 2], -1.0, 1.0)))
    if tilt > TILT:
        yield Finding(
            "error",
            element,
            f"is tilted by {tilt:.3f} rad against the flat part of its foot",
            "its frame, or 'offset', with z up out of the ground",
        )
    outline = np.column_stack((patch.outline, np.zeros(len(patch.outline))))
    corners = np.array([offset.act(corner)[:2] for corner in outline])
    low, high = corners.min(axis=0), corners.max(axis=0)
    for axis, (start, end), least, most in zip(
        "xy", (contact.x, contact.y), low, high, strict=True
    ):
        if start < least - HEIGHT or end > most + HEIGHT:
            yield Finding(
                "warning",
                element,
                f"reaches from {start:g} to {end:g} m along {axis}, the foot from {least:.3f} to "
                f"{most:.3f} m",
                f"a sole that is smaller than the foot, '{axis}: [{0.9 * least:.3f}, "
                f"{0.9 * most:.3f}]'",
            )
