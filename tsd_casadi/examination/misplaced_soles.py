"""Soles of a robot file against the shapes of the feet: is the ground where it says?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pinocchio

from tsd_casadi.examination.finding import Finding
from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.geometry import load_geometry
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import SoleFile
from tsd_casadi.robot.sole_patch import SolePatch, find_sole_patch

# a sole this far above or below the foot's underside stands in the air or in the ground:
# rubber and drawings differ by a few millimetres [m]
MISPLACED = 5e-3
# a sole tilted by this much touches with an edge: 5 mm on a foot of 25 cm [rad]
TILTED = 0.02
# a sole that is larger than the foot by less may be rounding of either [m]
OVERHANG = 2e-3
# beyond these it is no rounding: the controller would put the weight where no foot is,
# a fifth of the foot (its own margin is a tenth) or what tips an adult [-, m]
LARGEST_OVERHANG = 0.2, 0.02


def misplaced_soles(robot: Robot) -> Iterator[Finding]:
    """Find soles that are not where the feet are flat.

    Feet without flat shapes say nothing, and points have no sole.
    """
    model = robot.model
    for contact in robot.description.contacts:
        if not isinstance(contact, SoleFile):
            continue
        size = float(np.ptp([contact.x, contact.y], axis=1).max())
        if size > robot.home_com[2]:
            # no foot is as long as its leg: whatever the shapes say, or if there are none
            yield Finding(
                "error",
                f"contact {contact.name}",
                f"is {size:.3g} m long, more than the height of the centre of mass",
                f"metres, {_in_meters(contact)} if these are millimetres",
            )
            continue
        frame = robot.frame_id(contact.name)
        joint = model.frames[frame].parentJoint
        links = [
            str(each.name)
            for each in model.frames
            if each.parentJoint == joint and each.type == pinocchio.FrameType.BODY
        ]
        try:
            shapes = {
                "collision": load_geometry(robot.bodies, "collision", links).model,
                "visual": load_geometry(robot.bodies, "visual", links).model,
            }
            patch = find_sole_patch(robot.source_path, model, shapes, frame, robot.home.q)
        except RobotFileError:
            continue
        yield from _compare(robot, contact, frame, patch)


def _compare(robot: Robot, contact: SoleFile, frame: int, patch: SolePatch) -> Iterator[Finding]:
    model = robot.model
    sole = model.frames[frame].placement
    real = sole.actInv(model.frames[patch.index].placement * patch.placement)
    height = -float(real.translation[2])
    tilt = float(np.linalg.norm(real.rotation[:, 2] - [0, 0, 1]))
    element = f"contact {contact.name}"
    if abs(height) > MISPLACED or tilt > TILTED:
        ankle = float(np.linalg.norm(sole.translation)) < MISPLACED
        what = "is at the ankle, " if ankle else "is "
        yield Finding(
            # what is only drawn may be a cover
            "error" if patch.source == "collision" else "warning",
            element,
            f"{what}{1e3 * abs(height):.1f} mm {'above' if height > 0 else 'below'} the flat "
            f"underside of the foot's {patch.source} geometry and tilted by {tilt:.3f} rad to it",
            f"'frame: {contact.frame}' with {_offset(robot, contact, patch)}",
        )
        return
    outline = patch.outline @ real.rotation[:2, :2].T + real.translation[:2]
    low, high = outline.min(axis=0), outline.max(axis=0)
    extents = np.array([contact.x, contact.y])
    overs = np.maximum(low - extents[:, 0], extents[:, 1] - high)
    over = float(overs.max())
    if over > OVERHANG:
        share, length = LARGEST_OVERHANG
        is_far = over > length or bool((overs > share * (high - low)).any())
        yield Finding(
            "error" if is_far and patch.source == "collision" else "warning",
            element,
            f"is larger than the flat underside of the foot, by {1e3 * over:.1f} mm",
            f"x within [{low[0]:.3f}, {high[0]:.3f}], y within [{low[1]:.3f}, {high[1]:.3f}]",
        )


def _in_meters(contact: SoleFile) -> str:
    """Write what millimetres are in metres."""
    x, y = (f"[{low / 1e3:g}, {high / 1e3:g}]" for low, high in (contact.x, contact.y))
    return f"x: {x}, y: {y}"


def _offset(robot: Robot, contact: SoleFile, patch: SolePatch) -> str:
    """Write the offset from the frame that the contact names to where the foot is flat."""
    model = robot.model
    index = robot.bodies.find_frame(contact.frame)
    assert index is not None
    offset = model.frames[index].placement.actInv(
        model.frames[patch.index].placement * patch.placement
    )
    xyz, rpy = (
        f"[{', '.join(f'{value:.4f}' for value in values)}]"
        for values in (offset.translation, pinocchio.rpy.matrixToRpy(offset.rotation))
    )
    x, y = (f"[{low:.3f}, {high:.3f}]" for low, high in (patch.x, patch.y))
    return f"'offset: {{xyz: {xyz}, rpy: {rpy}}}', x: {x}, y: {y}"
