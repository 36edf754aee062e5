"""The sections of a proposed file that change its description."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tsd_casadi.proposal.locks import Locks
from tsd_casadi.proposal.survey import Survey
from tsd_casadi.proposal.yaml_text import DIGITS, key_text, list_text, number_text


def changes_text(found: Survey, efforts: Mapping[str, float]) -> list[str]:
    """Write what is locked, assumed and replaced, line by line.

    Args:
        efforts: Torque limits that the description lacks, by joint [N m].
    """
    lines = _locked(found.locks)
    if efforts:
        lines += [
            "",
            "# ASSUMED, the description has no torque limits: five times what a crouch takes.",
            "# Put in those of the motors. [N m]",
            "effort:",
            *(f"  {key_text(joint)}: {value:g}" for joint, value in efforts.items()),
        ]
    if found.position:
        lines += [
            "",
            "# These turn without end in the description; a limit is needed. [rad]",
            "position:",
            *(f"  {key_text(name)}: {list_text(ends)}" for name, ends in found.position.items()),
        ]
    if found.moments:
        lines += [
            "",
            "# No body can have the description's inertia of these: the nearest possible one,",
            "# or that of a ball of the same mass. xx, yy, zz, xy, xz, yz. [kg m^2]",
            "links:",
            *(f"  {key_text(link)}: {_inertia(each)}" for link, each in found.moments.items()),
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
        lines += [
            f"  {key_text(key)}: {number_text(locks.angles[each])}" for key, each in shown.items()
        ]
    reason = ""
    for joint, why in locks.reasons.items():
        if joint in named:
            continue
        if why != reason:
            lines.append(f"  # {why}")
            reason = why
        lines.append(_angle(locks, joint, joint))
    return lines


def _angle(locks: Locks, key: str, joint: str) -> str:
    return f"  {key_text(key)}: {number_text(locks.angles[joint])}"


def _inertia(moments: Sequence[float]) -> str:
    return f"{{inertia: [{', '.join(f'{value:.6g}' for value in moments)}]}}"
