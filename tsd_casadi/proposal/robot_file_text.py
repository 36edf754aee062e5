"""A proposed robot file, as text with the reasons in comments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.proposal.body import Body
from tsd_casadi.proposal.gains import Gains
from tsd_casadi.proposal.home_posture import P_COM, P_POSTURE, HomePosture
from tsd_casadi.proposal.inverse_statics import FRICTION
from tsd_casadi.proposal.locks import Locks
from tsd_casadi.proposal.survey import INSIDE, Survey
from tsd_casadi.robot.sole_patch import SolePatch

# of angles: 0.1 mrad moves a foot by less than 0.1 mm and tilts it by less than 0.3 mrad
DIGITS = 4
# turns smaller than this are rounding [rad]
UPRIGHT = 1e-5


def robot_file_text(
    name: str,
    source: str,
    found: Survey,
    home: HomePosture,
    gains: Gains,
    ranges: Mapping[str, Mapping[str, tuple[float, float]]],
    efforts: Mapping[str, float],
) -> str:
    """Write a robot file.

    Args:
        source: Path of the description as the file has to name it.
        ranges: (low, high) by motion and parameter.
        efforts: Torque limits that the description lacks, by joint [N m].

    Returns:
        YAML that the loader reads back.
    """
    parts = [
        _head(name, source, found),
        _changes(found, efforts),
        _home(found.body, home),
        _contacts(found.body, gains),
        _tasks(found, home),
        _weights(gains),
        _motions(ranges),
    ]
    return "\n".join("\n".join(part) + "\n" for part in parts if part)


def _head(name: str, source: str, found: Survey) -> list[str]:
    body = found.body
    return [
        f"# {name}: {body.mass:.1f} kg, {body.n} joints that move. Proposed by 'tsd robot new';",
        "# 'tsd robot check' looks at it again after you have changed something.",
        f"name: {name}",
        f"{found.description.kind}: {source}",
    ]


def _changes(found: Survey, efforts: Mapping[str, float]) -> list[str]:
    lines = _locked(found.locks)
    if efforts:
        lines += [
            "",
            "# ASSUMED, the description has no torque limits: five times what a crouch takes.",
            "# Put in those of the motors. [N m]",
            "effort:",
            *(f"  {_key(joint)}: {value:g}" for joint, value in efforts.items()),
        ]
    if found.position:
        lines += [
            "",
            "# These turn without end in the description; a limit is needed. [rad]",
            "position:",
            *(f"  {_key(joint)}: [{low}, {high}]" for joint, (low, high) in found.position.items()),
        ]
    if found.moments:
        lines += [
            "",
            "# No body can have the description's inertia of these: the nearest possible one,",
            "# or that of a ball of the same mass. xx, yy, zz, xy, xz, yz. [kg m^2]",
            "links:",
            *(
                f"  {_key(link)}: {{inertia: [{', '.join(f'{value:.6g}' for value in values)}]}}"
                for link, values in found.moments.items()
            ),
        ]
    return lines[1:] if lines[:1] == [""] else lines


def _locked(locks: Locks) -> list[str]:
    if not locks.angles:
        return []
    lines = ["# Joints that do not move. [rad]", "locked:"]
    named = {joint for joints in locks.patterns.values() for joint in joints}
    for pattern, joints in locks.patterns.items():
        angles = {round(locks.angles[joint], DIGITS) for joint in joints}
        # one angle for a pattern, or each joint by itself
        shown = {pattern: joints[0]} if len(angles) == 1 else {each: each for each in joints}
        lines += [f"  {_key(key)}: {_number(locks.angles[each])}" for key, each in shown.items()]
    reason = ""
    for joint, why in locks.reasons.items():
        if joint in named:
            continue
        if why != reason:
            lines.append(f"  # {why}")
            reason = why
        lines.append(f"  {_key(joint)}: {_number(locks.angles[joint])}")
    return lines


def _home(body: Body, home: HomePosture) -> list[str]:
    q = home.posed.q
    rotation = pinocchio.Quaternion(q[3:7]).matrix()
    lines: list[str] = []
    if np.linalg.norm(pinocchio.log3(rotation)) > UPRIGHT:
        lines += [
            f"# How the base link is turned in the world{_leaning(home)}. Roll, pitch, yaw. [rad]",
            f"base_orientation: {_list(pinocchio.rpy.matrixToRpy(rotation), 6)}",
            "",
        ]
    names = list(body.model.names)[2:]
    angles = {name: round(float(angle), DIGITS) for name, angle in zip(names, q[7:], strict=True)}
    lines += [
        f"# A crouch with the centre of mass {home.posed.height:.2f} m above the soles, knees bent",
        f"# by {home.posed.bend:.2f} rad; every joint is {home.posed.margin:.2f} rad or more from its",
        f"# limits and takes {100 * home.posed.share:.0f} % of its torque or less. Joints left out",
        "# are at zero. [rad]",
        "home:",
        *(f"  {_key(name)}: {_number(angle)}" for name, angle in angles.items() if angle),
    ]
    return lines


def _leaning(home: HomePosture) -> str:
    if not home.lean:
        return ""
    return f", {home.lean:g} rad of it a bow: upright, the ankles are too near to their limits"


def _contacts(body: Body, gains: Gains) -> list[str]:
    lines = [
        f"# Rectangles of {INSIDE:g} of the length and width of the flat patch under each foot:",
        "# at its edge contact is lost.",
        "contacts:",
    ]
    for name, sole in zip(("left_foot", "right_foot"), body.soles, strict=True):
        lines += [
            f"  - name: {name}",
            f"    frame: {_key(sole.frame)}",
            *_offset(sole),
            f"    x: {_list(sole.x)}  # m",
            f"    y: {_list(sole.y)}  # m",
            f"    friction: {FRICTION:g}",
            f"    torsional_friction: {gains.torsional_friction:g}  # m",
            f"    minimum_force: {gains.minimum_force:g}  # N",
        ]
    return lines


def _offset(sole: SolePatch) -> list[str]:
    if sole.is_frame:
        return []
    xyz = _list(sole.placement.translation, 5)
    rpy = _list(pinocchio.rpy.matrixToRpy(sole.placement.rotation), 6)
    return [f"    offset: {{xyz: {xyz}, rpy: {rpy}}}  # m, rad; from there to the sole, z up"]


def _tasks(found: Survey, home: HomePosture) -> list[str]:
    body, bodies = found.body, found.bodies
    damping = f"{2 * np.sqrt(P_COM):.4f}"
    gains = "P: 100.0, D: 20.0, W: 1.0"
    both = {"pelvis": body.pelvis, "torso": body.trunk}
    if body.pelvis == body.trunk:
        del both["pelvis"]
    lines = [
        "# Gains are low on purpose: what the model gets wrong is learned. P [1/s^2], critically",
        "# damped D [1/s], weight W.",
        "tasks:",
        f"  - {{type: com, name: com, P: {P_COM}, D: {damping}, W: 10.0}}",
    ]
    for name, joint in both.items():
        axes = ("rx", "ry", "rz") if joint == 1 else body.trunk_axes(home.posed.q)
        if axes:
            frame = _key(bodies.link_of(joint))
            lines.append(
                f"  - {{type: frame, name: {name}, frame: {frame}, "
                f"axes: [{', '.join(axes)}], {gains}}}"
            )
    return lines


def _weights(gains: Gains) -> list[str]:
    return [
        f"posture: {{P: {P_POSTURE}, D: 12.0, W: 0.01}}",
        "",
        "# Scaled to the robot's weight and height.",
        "regularization:",
        f"  force: {gains.force!r}",
        f"  moment: {gains.moment!r}",
        "  acceleration: 1.0e-05",
        "",
        "limits:",
        f"  acceleration: {gains.acceleration!r}  # rad/s^2",
        "",
        f"safe_torque: {{D: {gains.damping!r}}}  # N m s/rad",
    ]


def _motions(ranges: Mapping[str, Mapping[str, tuple[float, float]]]) -> list[str]:
    if not ranges:
        return []
    lines = [
        "# Over these ranges every joint keeps 0.1 rad to its limits and the knees stay bent by",
        "# 0.6 rad, with the sag of a model that is 10 % wrong. [m, rad, Hz]",
        "motions:",
    ]
    for motion, parameters in ranges.items():
        lines.append(f"  {motion}:")
        lines += [f"    {name}: {_list(ends)}" for name, ends in parameters.items()]
    return lines


def _list(values: Sequence[float] | Any, digits: int = 4) -> str:
    return f"[{', '.join(_number(float(value), digits) for value in values)}]"


def _number(value: float, digits: int = DIGITS) -> str:
    return repr(round(value, digits) + 0.0)  # minus zero is zero


def _key(name: str) -> str:
    """Quote what YAML would not read as the text that it is."""
    plain = name.replace("_", "").isalnum() and name[:1].isalpha()
    reserved = name.lower() in ("on", "off", "yes", "no", "true", "false", "null", "y", "n")
    return name if plain and not reserved else "'" + name.replace("'", "''") + "'"
