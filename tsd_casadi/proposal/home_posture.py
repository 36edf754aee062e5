"""A crouch to work from: soles flat, joints free to move, torques to spare."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.proposal.arms import hang_arms, sag
from tsd_casadi.proposal.body import Body
from tsd_casadi.proposal.inverse_statics import torque_shares
from tsd_casadi.proposal.stance import Wish, settle, sole_places
from tsd_casadi.state import Matrix, Vector

# stiffness of tasks and posture in every proposed file [1/s^2], and the model error that a
# robot has to bear without leaving its range
P_COM, P_POSTURE, MODEL_ERROR = 50.0, 40.0, 0.1
# the centre of mass sags by what is missing of g: 20 mm at a stiffness of 50
SAG = MODEL_ERROR * 9.81 / P_COM
# every joint keeps this to its limits, knees stay bent by at least so much [rad]
LEAST_MARGIN, LEAST_BEND = 0.1, 0.6
# of angles that the solver holds at those bounds [rad]
TOLERANCE = 1e-4
# of a joint's torque, at the bottom of the slow motion: the rest is for 10 % more mass,
# for acceleration and for the feedback
LARGEST_SHARE = 0.8
# knees at home, deepest first: deeper crouches learn better, until torques are the limit
BENDS = tuple(np.round(np.arange(0.5, 2.01, 0.1), 2))
DEEPEST_HOME = 1.25
# a squat that is worth learning, and a comfortable one in shares of the standing height
WORTHWHILE, COMFORTABLE = 0.03, 0.05
# upper body pitched forward, tried in turn where upright leaves too little room [rad]
LEANS = (0.0, 0.15, 0.3, 0.45, 0.6)
# squats for which a smaller lean is good enough, better ones first [m]
GOOD_ENOUGH = (0.025, 0.01)
# widths in shares of where the feet are at neutral, tried where the robot cannot stand else
WIDTHS = (1.0, 1.25, 0.8)
# between the soles' edges, at least [m]
GAP = 0.02


@dataclass(frozen=True)
class Posed:
    """One posture of the family over the knees' bend.

    Attributes:
        q: Configuration, (nq,).
        bend: Of the knees [rad].
        height: Of the centre of mass above the soles [m].
        margin: Least distance of a joint to a limit, sag taken off [rad].
        share: Largest torque / limit.
    """

    q: Vector
    bend: float
    height: float
    margin: float
    share: float

    @property
    def is_good(self) -> bool:
        """Whether a motion may go through this posture."""
        return (
            self.bend >= LEAST_BEND - TOLERANCE
            and self.margin >= LEAST_MARGIN - TOLERANCE
            and self.share <= LARGEST_SHARE
        )


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
            if found is not None and found.amplitude >= GOOD_ENOUGH[0]:
                return found
        for amplitude in GOOD_ENOUGH:
            enough = [each for each in tried if each.amplitude >= amplitude]
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


def pose(body: Body, q: Vector) -> Posed:
    """Measure a posture at rest."""
    model = body.model
    data = model.createData()
    com = pinocchio.centerOfMass(model, data, q)
    distance = np.minimum(q[7:] - body.low, body.high - q[7:])
    margin = float(np.min(distance - sag(body, q, MODEL_ERROR, P_POSTURE)))
    shares = torque_shares(body, q, np.zeros(model.nv))
    share = float("inf") if shares is None else float(shares.max())
    bend = min(leg.bend(model, q) for leg in body.legs)
    return Posed(q, bend, float(com[2]), margin, share)


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
