"""Masses and inertias that no body can have: refused, replaced or told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.description import Description
from tsd_casadi.robot.inertias import (
    possible_moments,
    sphere_moment,
    what_is_wrong,
    written_inertia,
)
from tsd_casadi.robot.rigid_body_model import RigidBodyModel

Moments = dict[str, tuple[float, float, float, float, float, float]]

# moments this much smaller than those of a ball of the same mass are rounding, not steel
NOTHING = 1e-3
# the heaviest humanoids have 200 kg; one of more than this has a mass in other units [kg]
HEAVIEST = 500.0
# of the robot's mass: the heaviest links of the public humanoids, their torsos, have less
DOMINANT = 0.5


def check_masses(description: Description) -> None:
    """Refuse masses that are negative or no numbers, of links that are fixed to others too.

    Raises:
        RobotFileError: If a link has one; it names the link.
    """
    for name, link in description.links().items():
        inertial = link.find("inertial")
        if inertial is None:
            continue
        try:
            wrong = _wrong_mass(description, link)
        except ValueError as error:
            wrong = f"its mass or inertia is not a number ({error})"
        if wrong is not None:
            raise RobotFileError(
                description.path,
                f"link {name}",
                wrong,
                "its mass in kg and its inertia in kg m^2 in the description; a link without "
                "mass has no <inertial>",
            )


def check_carried(path: Any, model: Any, legs: Sequence[str]) -> None:
    """Refuse a joint of a leg that moves nothing with a mass, such as a foot of 0 kg.

    Args:
        path: The description, for errors.
        model: ``pinocchio.Model`` of all joints.
        legs: Joints between the base and the feet.

    Raises:
        RobotFileError: If there is one; it names the joint and its link.
    """
    data = model.createData()
    pinocchio.computeSubtreeMasses(model, data)
    for joint in legs:
        j = model.getJointId(joint)
        if not data.mass[j] > 0:
            links = [
                str(frame.name)
                for frame in model.frames
                if frame.parentJoint == j and frame.type == pinocchio.FrameType.BODY
            ]
            raise RobotFileError(
                path,
                f"link {', '.join(links)}",
                f"has no mass, and joint {joint} of a leg moves nothing else",
                "its mass in kg and its inertia in kg m^2 in the description",
            )


def heavy_links(bodies: RigidBodyModel) -> list[str]:
    """Tell of a mass that a robot hardly has, a line each."""
    masses = {
        bodies.link_of(joint): float(inertia.mass)
        for joint, inertia in enumerate(list(bodies.model.inertias)[1:], start=1)
    }
    total = sum(masses.values())
    notes = [
        f"link {link} has {mass:.4g} kg, {100 * mass / total:.0f} % of the robot"
        for link, mass in masses.items()
        if mass > DOMINANT * total
    ]
    if total > HEAVIEST:
        heaviest = max(masses, key=lambda link: masses[link])
        notes = notes or [f"the heaviest link is {heaviest} with {masses[heaviest]:.4g} kg"]
        notes[0] = f"the robot has {total:.4g} kg, {notes[0]}: in grams?"
    return notes


def mend_inertias(bodies: RigidBodyModel) -> Moments:
    """Find possible moments for what cannot be.

    Returns:
        (xx, yy, zz, xy, xz, yz) about the centre of mass, axes of the link [kg m^2], by
        the link that the joint of an impossible body moves; zeros for links without mass.
    """
    mended: Moments = {}
    for joint, inertia in enumerate(list(bodies.model.inertias)[1:], start=1):
        if what_is_wrong(inertia) is None:
            continue
        if inertia.mass > 0:
            mended[bodies.link_of(joint)] = _moments(inertia)
        else:
            mended |= dict.fromkeys(_with_inertia(bodies, joint), (0.0,) * 6)
    return mended


def _with_inertia(bodies: RigidBodyModel, joint: int) -> list[str]:
    """Name the links of a body that are written with an inertia."""
    links = bodies.description.links()
    return [
        str(frame.name)
        for frame in bodies.model.frames
        if frame.parentJoint == joint
        and frame.type == pinocchio.FrameType.BODY
        and frame.name in links
        and links[frame.name].find("inertial") is not None
    ]


def _moments(inertia: Any) -> tuple[float, float, float, float, float, float]:
    ball = sphere_moment(float(inertia.mass))
    if np.linalg.eigvalsh(np.array(inertia.inertia))[-1] < NOTHING * ball:
        return (ball, ball, ball, 0.0, 0.0, 0.0)
    return possible_moments(inertia)


def _wrong_mass(description: Description, link: Any) -> str | None:
    """Tell what is wrong with a mass that cannot be mended.

    Raises:
        ValueError: If it is not written as a number.
    """
    if description.kind == "urdf":
        inertia = written_inertia(link)
        if inertia is None:
            return None
        mass, numbers = inertia.mass, [inertia.mass, *inertia.inertia.flat]
    else:
        # only this: moments are written in four ways, of which the parser tells
        mass = float(link.find("inertial").get("mass", "0"))
        numbers = [mass]
    if not np.isfinite(numbers).all():
        return "its mass or inertia is not a number"
    return f"its mass is negative, {mass:g} kg" if mass < 0 else None
