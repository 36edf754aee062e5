"""A proposed robot file, as text with the reasons in comments."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio

from tsd_casadi.proposal.body import Body
from tsd_casadi.proposal.changes_text import changes_text
from tsd_casadi.proposal.gains import Gains
from tsd_casadi.proposal.home_posture import HomePosture
from tsd_casadi.proposal.inverse_statics import FRICTION
from tsd_casadi.proposal.motions_text import motions_text
from tsd_casadi.proposal.posed import P_COM, P_POSTURE
from tsd_casadi.proposal.soles import INSIDE
from tsd_casadi.proposal.survey import Survey
from tsd_casadi.proposal.yaml_text import DIGITS, key_text, list_text, number_text
from tsd_casadi.robot.sole_patch import SolePatch

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
        changes_text(found, efforts),
        _home(found.body, home),
        _contacts(found.body, gains),
        _tasks(found, home),
        _weights(gains),
        motions_text(ranges),
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


def _home(body: Body, home: HomePosture) -> list[str]:
    posed = home.posed
    q = posed.q
    rotation = pinocchio.Quaternion(q[3:7]).matrix()
    lines: list[str] = []
    if np.linalg.norm(pinocchio.log3(rotation)) > UPRIGHT:
        lines += [
            "# How the base link is turned where the robot stands. Roll, pitch, yaw. [rad]",
            *_leaning(home),
            f"base_orientation: {list_text(pinocchio.rpy.matrixToRpy(rotation), 6)}",
            "",
        ]
    names = list(body.model.names)[2:]
    angles = {name: round(float(angle), DIGITS) for name, angle in zip(names, q[7:], strict=True)}
    lines += [
        f"# A crouch with the centre of mass {posed.height:.2f} m above the soles, the knees",
        f"# bent by {posed.bend:.2f} rad; every joint keeps {posed.margin:.2f} rad to its limits",
        f"# and takes at most {100 * posed.share:.0f} % of its torque. Joints left out are at",
        "# zero. [rad]",
        "home:",
        *(f"  {key_text(name)}: {number_text(angle)}" for name, angle in angles.items() if angle),
    ]
    return lines


def _leaning(home: HomePosture) -> list[str]:
    if not home.lean:
        return []
    return [
        f"# {home.lean:g} rad of it is a bow: upright, the ankles come too near to their limits."
    ]


def _contacts(body: Body, gains: Gains) -> list[str]:
    lines = [
        f"# Rectangles of {INSIDE:g} of the length and width of the flat patch under each foot:",
        "# at its edge contact is lost.",
        "contacts:",
    ]
    for name, sole in zip(("left_foot", "right_foot"), body.soles, strict=True):
        lines += [
            f"  - name: {name}",
            f"    frame: {key_text(sole.frame)}",
            *_offset(sole),
            f"    x: {list_text(sole.x)}  # m",
            f"    y: {list_text(sole.y)}  # m",
            f"    friction: {FRICTION:g}",
            f"    torsional_friction: {gains.torsional_friction:g}  # m",
            f"    minimum_force: {gains.minimum_force:g}  # N",
        ]
    return lines


def _offset(sole: SolePatch) -> list[str]:
    if sole.is_frame:
        return []
    xyz = list_text(sole.placement.translation, 5)
    rpy = list_text(pinocchio.rpy.matrixToRpy(sole.placement.rotation), 6)
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
            frame = key_text(bodies.link_of(joint))
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
