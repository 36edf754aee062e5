"""Whether a robot's file, its URDF and its postures fit together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.exceptions.did_you_mean import nearest
from tsd_casadi.robot.inertias import override_lines, what_is_wrong

if TYPE_CHECKING:
    from tsd_casadi.robot.robot import Robot

# how far home may leave the feet from lying flat on one plane [m, -]
FLATNESS = 1e-3
# more than any motor: a number that stands for no limit [N m]
HIGHEST_TORQUE = 1e6


def check_robot(robot: Robot) -> None:
    """Refuse a robot that no controller could be made for.

    Raises:
        RobotFileError: If a name is unknown, a limit is missing or exceeded, a
            posture does not stand flat, or the feet span no area to stand on.
    """
    _check_joints(robot)
    _check_torque_limits(robot)
    _check_inertias(robot)
    _check_angles(robot)
    _check_weight(robot)
    _check_feet_on_ground(robot)
    _check_support(robot)


def _postures(robot: Robot) -> list[tuple[str, str, dict[str, float]]]:
    """List name, field and joint angles of every posture of the file."""
    others = robot.description.postures.items()
    return [
        ("home", "home", robot.description.home),
        *((name, f"postures.{name}", joints) for name, joints in others),
    ]


def _check_joints(robot: Robot) -> None:
    locked = [robot.bodies.full.names[index] for index in robot.bodies.locked]
    for _, field, joints in _postures(robot):
        for joint in joints:
            if joint in locked:
                raise RobotFileError(
                    robot.path, f"{field}.{joint}", "is locked", f"its angle at 'locked.{joint}'"
                )
            if joint not in robot.joint_names:
                raise RobotFileError(
                    robot.path,
                    f"{field}.{joint}",
                    f"is no joint of {robot.source_path.name}",
                    nearest(joint, robot.joint_names),
                )


def _check_torque_limits(robot: Robot) -> None:
    for joint, limit in zip(robot.joint_names, robot.torque_limit, strict=True):
        if not 0 < limit < HIGHEST_TORQUE:
            raise RobotFileError(
                robot.source_path,
                f"joint {joint}, limit, effort",
                f"is {limit:g}",
                "a positive torque limit in N m, there or in the robot file, "
                f"'effort: {{{joint}: 50.0}}'; or the joint locked, 'locked: {{{joint}: 0.0}}'",
            )


def _check_inertias(robot: Robot) -> None:
    model = robot.model
    for joint in range(1, model.njoints):
        inertia = model.inertias[joint]
        wrong = what_is_wrong(inertia)
        link = robot.bodies.link_of(joint)
        if wrong is not None:
            lines = override_lines(link, inertia)
            expected = f"what a body can have, for instance in {robot.path.name}: {lines}"
            raise RobotFileError(robot.source_path, f"link {link}", wrong, expected)
    data = model.createData()
    pinocchio.computeSubtreeMasses(model, data)
    for joint in range(2, model.njoints):
        if not data.mass[joint] > 0:
            name = model.names[joint]
            raise RobotFileError(
                robot.source_path,
                f"joint {name}",
                "moves nothing that has a mass",
                f"masses behind it, or 'locked: {{{name}: 0.0}}' in {robot.path.name}",
            )


def _check_angles(robot: Robot) -> None:
    """See to the limits of every joint of a posture, of those that are not written too."""
    model = robot.model
    for name, field, joints in _postures(robot):
        q = robot.posture(name).q
        for joint in robot.joint_names:
            index = model.joints[model.getJointId(joint)].idx_q
            low, high = model.lowerPositionLimit[index], model.upperPositionLimit[index]
            if not low <= q[index] <= high:
                left_out = "" if joint in joints else ", since it is left out"
                raise RobotFileError(
                    robot.path,
                    f"{field}.{joint}",
                    f"is {q[index]:g} rad{left_out}",
                    f"a value from {low:g} to {high:g} rad",
                )


def _check_weight(robot: Robot) -> None:
    least = sum(contact.minimum_force for contact in robot.description.contacts)
    if robot.weight <= least:
        raise RobotFileError(
            robot.path,
            "contacts",
            f"press on the ground with {least:g} N at least, the robot weighs {robot.weight:.3g} N",
            "minimum forces that add up to less than the weight, or the masses of the robot",
        )


def _check_feet_on_ground(robot: Robot) -> None:
    for name, field, _ in _postures(robot):
        placements = robot.sole_placements(robot.posture(name).q)
        heights = [float(placement.translation[2]) for placement in placements]
        wrong = []
        if max(map(abs, heights)) > FLATNESS:
            # the ground is in the middle of them: each is off by a part of what they differ
            low, high = (robot.feet[heights.index(end(heights))].name for end in (min, max))
            apart = 1e3 * (max(heights) - min(heights))
            wrong.append(f"{high} {apart:.1f} mm above {low}")
        tilts = [
            (foot.tilt(placement), foot.name)
            for foot, placement in zip(robot.feet, placements, strict=True)
        ]
        wrong += [f"{foot} tilted by {tilt:.4f} rad" for tilt, foot in tilts if tilt > FLATNESS]
        if wrong:
            raise RobotFileError(
                robot.path,
                field,
                f"leaves {', '.join(wrong)}",
                "joint angles with all soles flat and all points on one plane; if the angles are "
                "right, the contact's 'offset' (and 'frame') that leads to where the foot is flat",
            )


def _check_support(robot: Robot) -> None:
    """Refuse feet that lie on a line: nothing could balance on them."""
    places = zip(robot.feet, robot.sole_placements(robot.home.q), strict=True)
    corners = np.vstack([foot.corners(place)[:, :2] for foot, place in places])
    widths = np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)
    if len(corners) < 3 or widths[-1] < FLATNESS:
        raise RobotFileError(
            robot.path,
            "contacts",
            "the feet touch the ground along a line, which nothing can balance on",
            "a sole, or at least three points that are not in line",
        )
