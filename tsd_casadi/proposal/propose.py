"""A robot file from a description and the names of two feet."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.proposal.efforts import assumed_limits
from tsd_casadi.proposal.gains import scale_gains
from tsd_casadi.proposal.home_posture import GOOD_ENOUGH, HomePosture, find_home_posture
from tsd_casadi.proposal.motion_ranges import propose_ranges
from tsd_casadi.proposal.posed import LARGEST_SHARE, LEAST_BEND, LEAST_MARGIN, SAG
from tsd_casadi.proposal.robot_file_text import robot_file_text
from tsd_casadi.proposal.source_path import path_in_file
from tsd_casadi.proposal.survey import Survey, survey

# what a proposal is made in, for whoever shows progress
STEPS = ("description", "home posture", "ranges of motions", "file")
# more names than these are counted
FEW = 6


@dataclass(frozen=True)
class Proposal:
    """A robot file that is not written yet.

    Attributes:
        name: Of the robot.
        text: YAML.
        notes: What was found, locked and assumed, a line each.
        survey: Of the description.
        home: Where the robot stands.
        ranges: (low, high) by motion and parameter.
        problems: Why the file is of no use as it is, a line each; usually none.
    """

    name: str
    text: str
    notes: list[str]
    survey: Survey
    home: HomePosture
    ranges: dict[str, dict[str, tuple[float, float]]]
    problems: list[str]


def propose_robot_file(
    source: Path,
    feet: tuple[str, str],
    locks: Sequence[str],
    name: str,
    robot_file: Path,
    progress: Callable[[float, float], None] = lambda done, total: None,
) -> Proposal:
    """Propose a robot file.

    Args:
        source: URDF, xacro or MJCF.
        feet: Names of the left and of the right foot: links, or frames on them.
        locks: Joints that are not to move, names or regular expressions.
        robot_file: Where it is to be written: it names its description from there.
        progress: Told (steps done, all steps).

    Raises:
        RobotFileError: If the description cannot be used, or the robot does not stand.
    """
    total = len(STEPS)
    named = path_in_file(source, robot_file)
    found = survey(source, feet, locks)
    progress(1, total)
    home = find_home_posture(found.body)
    if home is None:
        odd = [*found.suspicions, *found.mistakes]
        if odd:
            raise RobotFileError(
                source,
                "",
                f"leads to no posture that the robot can crouch in; what is odd: {'; '.join(odd)}",
                "other numbers there",
            )
        raise RobotFileError(
            source,
            "joint limits",
            "leave no posture with both soles flat, the knees bent by "
            f"{LEAST_BEND:g} rad and {LEAST_MARGIN:g} rad to every limit",
            "limits of these joints and no others: "
            + ", ".join(_leg_limits(found))
            + "; or feet that are named in the other order",
        )
    progress(2, total)
    ranges = propose_ranges(found.body, home)
    progress(3, total)
    efforts = assumed_limits(found.body, home)
    text = robot_file_text(name, named, found, home, scale_gains(found.body, home), ranges, efforts)
    progress(4, total)
    notes = [
        *found.notes,
        *_about_home(found, home),
        *_about_efforts(efforts),
        *found.suspicions,
    ]
    return Proposal(name, text, notes, found, home, ranges, _problems(found, home, ranges))


def _problems(
    found: Survey, home: HomePosture, ranges: dict[str, dict[str, tuple[float, float]]]
) -> list[str]:
    problems = list(found.mistakes)
    if not ranges:
        free = 1e3 * max(home.amplitude + SAG, 0.0)
        problems.append(
            f"there is no room for any motion: with {LEAST_MARGIN:g} rad to every limit, knees "
            f"bent by {LEAST_BEND:g} rad and {100 * LARGEST_SHARE:.0f} % of the torques home "
            f"leaves {free:.0f} mm up and down, of which the sag of a model that is 10 % wrong "
            f"takes {1e3 * SAG:.0f} mm; look at these limits, at masses and soles: "
            + ", ".join(_leg_limits(found))
        )
    return problems


def name_for(text: str) -> str:
    """Make a robot's name of a file's: letters, digits and underscores."""
    name = re.sub(r"[^A-Za-z0-9_]+", "_", text).strip("_")
    return name if name[:1].isalpha() else f"robot_{name}".rstrip("_")


def _about_home(found: Survey, home: HomePosture) -> list[str]:
    posed, body = home.posed, found.body
    knees = " and ".join(str(body.model.names[leg.knee]) for leg in body.legs)
    notes = [
        f"home: centre of mass {posed.height:.3f} m above the soles, {knees} bent by "
        f"{posed.bend:.2f} rad, {posed.margin:.2f} rad to the nearest limit, at most "
        f"{100 * posed.share:.0f} % of a joint's torque"
    ]
    turned = found.body.upright
    if not np.allclose(turned, np.eye(3), atol=1e-6):
        notes.append("the base link is not upright and facing along x: base_orientation turns it")
    if home.lean:
        notes.append(
            f"the upper body leans {home.lean:g} rad forward: upright, the ankles' limits leave "
            "less room for a squat"
        )
    if home.amplitude < GOOD_ENOUGH[-1][0]:
        notes.append(
            f"there is room for a squat of {1e3 * max(home.amplitude, 0):.0f} mm only; the "
            "joints' limits are near"
        )
    return notes


def _about_efforts(efforts: dict[str, float]) -> list[str]:
    if not efforts:
        return []
    joints = f"{len(efforts)} joints are" if len(efforts) > 1 else "one joint is"
    return [
        f"torque limits of {joints} ASSUMED, the description has none: put in "
        f"those of the motors ('effort' in the file): {_some(efforts)}"
    ]


def _some(joints: dict[str, float]) -> str:
    more = f" and {len(joints) - FEW} more" if len(joints) > FEW else ""
    return ", ".join(list(joints)[:FEW]) + more


def _leg_limits(found: Survey) -> list[str]:
    model = found.body.model
    return [
        f"{model.names[j]} [{model.lowerPositionLimit[model.joints[j].idx_q]:.2f}, "
        f"{model.upperPositionLimit[model.joints[j].idx_q]:.2f}]"
        for leg in found.body.legs
        for j in leg.joints
    ]
