"""The section of a proposed file with the ranges of motions."""

from __future__ import annotations

from collections.abc import Mapping

from tsd_casadi.proposal.motion_ranges import MOTIONS, SMALLEST
from tsd_casadi.proposal.yaml_text import list_text


def motions_text(ranges: Mapping[str, Mapping[str, tuple[float, float]]]) -> list[str]:
    """Write what the robot can do of each motion, line by line.

    Args:
        ranges: (low, high) by motion and parameter; those left out have no room.
    """
    lines = [
        "# Over these ranges every joint keeps 0.1 rad to its limits and the knees stay bent by",
        "# 0.6 rad, with the sag of a model that is 10 % wrong. [m, rad, Hz]",
        "motions:",
    ]
    for motion, parameters in ranges.items():
        lines.append(f"  {motion}:")
        lines += [f"    {name}: {list_text(ends)}" for name, ends in parameters.items()]
    without = [motion for motion in MOTIONS if motion not in ranges]
    if without:
        # left out, they would get what inverse kinematics reaches, without the margins
        lines += ["  # NO ROOM was found for these: the smallest range that a file can have."]
        lines += [f"  {motion}: {{amplitude: {list_text((0.0, SMALLEST))}}}" for motion in without]
    return lines
