"""A crouch to work from: soles flat, joints free to move, torques to spare."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.proposal.arms import hang_arms
from tsd_casadi.proposal.body import Body
from tsd_casadi.proposal.posed import SAG, Posed, pose
from tsd_casadi.proposal.stance import Wish, settle, sole_places
from tsd_casadi.state import Matrix, Vector

# knees at home, deepest first: deeper crouches learn better, until torques are the limit
BENDS = tuple(np.round(np.arange(0.5, 2.01, 0.1), 2))
DEEPEST_HOME = 1.6
# a squat that is worth learning, and a comfortable one in shares of the standing height
WORTHWHILE, COMFORTABLE = 0.03, 0.05
# upper body pitched forward, tried in turn where upright leaves too little room [rad]
LEANS = (0.0, 0.15, 0.3, 0.45, 0.6)
# a bow that nobody minds [rad]
SLIGHT = 0.3
# squats and bends of the knees for which a smaller lean is good enough, better ones first;
# for the bend alone nobody bows by more than slightly. From 1.16 to 1.28 rad, what the first
# iteration leaves of the error of a 33 kg humanoid fell from 1/33 to 1/53 [m, rad]
GOOD_ENOUGH = ((0.025, 1.2), (0.025, 0.0), (0.01, 0.0))
# widths in shares of where the feet are at neutral, tried where the robot cannot stand else
WIDTHS = (1.0, 1.25, 0.8)
# between the soles' edges, at least [m]
GAP = 0.02


@dataclass(frozen=True)
class HomePosture:
    """Where a robot's motions are about.

    Attributes:
        posed: The posture.
        amplitude: Of the largest squat about it, half of peak to peak [m].
        places: Of the soles' frames.
        lean: Of the pelvis, forward [rad].
        family: Postures around it that were tried, by rising bend.
    """

    posed: Posed
    amplitude: float
    places: tuple[Any, Any]
    lean: float
    family: tuple[Posed, ...]


def find_home_posture(body: Body) -> HomePosture | None:
    """Find the home posture; None if the robot cannot stand flat on both soles.

    Upright with the feet under the hips is tried first; a leaning upper body where
    that leaves no room for a squat, other widths where it does not stand at all.
    """
    preferred = hang_arms(body)
    for width in WIDTHS:
        tried: list[HomePosture] = []
        for lean in LEANS:
            found = _home_in(body, preferred, width * _natural_width(body), lean)
            tried += [] if found is None else [found]
            if found is not None and _is_enough(found, *GOOD_ENOUGH[0]):
                return found
        for amplitude, bend in GOOD_ENOUGH:
            enough = [each for each in tried if _is_enough(each, amplitude, bend)]
            if enough:
                return enough[0]
        if tried:
            return max(tried, key=lambda each: each.amplitude)
    return None


def leaned(body: Body, q: Vector, lean: float) -> tuple[Matrix, Matrix]:
    """Compute the rotations of pelvis and trunk, both pitched forward.

    Args:
        q: Configuration that is upright, (nq,).
        lean: [rad].
    """
    data = body.model.createData()
    pinocchio.forwardKinematics(body.model, data, q)
    pitch = pinocchio.exp3(np.array([0.0, lean, 0.0]))
    return pitch @ data.oMi[body.pelvis].rotation, pitch @ data.oMi[body.trunk].rotation


def _is_enough(home: HomePosture, amplitude: float, bend: float) -> bool:
    deep = home.posed.bend >= bend and (home.lean <= SLIGHT or not bend)
    return deep and home.amplitude >= amplitude


def _home_in(body: Body, preferred: Vector, width: float, lean: float) -> HomePosture | None:
    places = sole_places(body, width)
    pelvis, trunk = leaned(body, preferred, lean)
    family: list[Posed] = []
    start = preferred
    for bend in BENDS:
        com = np.array([0.0, 0.0, np.nan])
        wish = Wish(places, com, pelvis, trunk, float(bend))
        found = settle(body, _bent(body, start, float(bend)), preferred, wish)
        if found is None and start is not preferred:
            found = settle(body, _bent(body, preferred, float(bend)), preferred, wish)
        if found is None:
            continue
        start = found
        family.append(pose(body, found))
    run = _longest_run(family)
    if not run:
        return None
    low, high = run[-1].height, run[0].height
    room = 0.5 * (high - low) - SAG
    wanted = min(room, max(WORTHWHILE, COMFORTABLE * high))
    # the deepest that leaves room below, but not deeper than there is a reason for
    bends, heights = [each.bend for each in run], [each.height for each in run]
    deepest = float(np.interp(DEEPEST_HOME, bends, heights))
    height = max(low + wanted + SAG, min(deepest, high - SAG - WORTHWHILE))
    if room < WORTHWHILE:
        height = 0.5 * (low + high)
    bend = float(np.interp(-height, [-h for h in heights], bends))
    wish = Wish(places, np.array([0.0, 0.0, np.nan]), pelvis, trunk, bend)
    nearest = min(run, key=lambda each: abs(each.bend - bend))
    q = settle(body, nearest.q, preferred, wish)
    if q is None:
        return None
    posed = pose(body, q)
    amplitude = min(posed.height - low, high - posed.height) - SAG
    return HomePosture(posed, amplitude, places, lean, tuple(family))


def _bent(body: Body, q: Vector, bend: float) -> Vector:
    bent = q.copy()
    for leg in body.legs:
        bent[body.model.joints[leg.knee].idx_q] = leg.straight + leg.sign * bend
    return bent


def _longest_run(family: Sequence[Posed]) -> list[Posed]:
    """Find the most postures in a row that are all good."""
    best: list[Posed] = []
    run: list[Posed] = []
    for each in family:
        run = [*run, each] if each.is_good else []
        if len(run) > len(best):
            best = run
    return best


def _natural_width(body: Body) -> float:
    """Compute how far apart the soles' middles are at neutral, edges apart [m]."""
    model, data = body.model, body.model.createData()
    pinocchio.framesForwardKinematics(model, data, body.neutral())
    middles = [
        data.oMf[frame].act(np.array([np.mean(sole.x), np.mean(sole.y), 0.0]))[1]
        for frame, sole in zip(body.sole_frames, body.soles, strict=True)
    ]
    halves = sum(0.5 * float(np.ptp(sole.y)) for sole in body.soles)
    return float(max(middles[0] - middles[1], halves + GAP))
