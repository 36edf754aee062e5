r"""How far each motion may go: the margins hold over the whole motion, sag included.

The centre of pressure of a motion sideways swings by

.. math:: A (1 + \omega^2 z / g)

and the centre of mass sags, or rises, by what a model that is 10 % wrong leaves to
the feedback: each motion is looked at that much too low and that much too high.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import pinocchio

from tsd_casadi.proposal.arms import hang_arms
from tsd_casadi.proposal.body import Body
from tsd_casadi.proposal.gains import TORSION
from tsd_casadi.proposal.home_posture import WORTHWHILE, HomePosture, leaned
from tsd_casadi.proposal.posed import SAG, pose
from tsd_casadi.proposal.stance import Wish, settle
from tsd_casadi.state import Vector

# those that ranges are looked for
MOTIONS = ("squat", "sway", "lean", "circle", "twist")

Ranges = dict[str, tuple[float, float]]

# smallest motion that is one [m, rad], and the slowest [Hz]
SMALLEST, SLOWEST = 0.001, 0.05
# of the room above and below home: the rest is for the middle of a squat to be elsewhere
SQUAT_SHARE = 0.7
# fastest squat and fastest motion to a side [Hz]
FASTEST, FASTEST_ASIDE = 1.0, 0.3
# of g, as the vertical acceleration of the fastest squat: the feet stay loaded
LIGHTEST = 0.3
# kept between the centre of pressure and the edge of the soles [m]
PRESSURE_MARGIN = 0.01
# of the way from the middle to the middle of one sole: the other still carries 35 %. Two
# narrow-footed humanoids of ten whose model was 10 % wrong fell at shares of 0.4 and more
UNLOADED = 0.3
# largest motions that are tried [m, rad]
FARTHEST, FARTHEST_TURN = 0.3, 0.5
# of the normal torque that the soles' friction bears, for turning the upper body
TURNING_SHARE = 0.5
# the trunk is where it should be: turning it is wished for, not enforced [rad]
TURNED = 0.01
# halvings, to half a percent of that
HALVINGS = 8


def propose_ranges(body: Body, home: HomePosture) -> dict[str, Ranges]:
    """Find the ranges of the shipped motions' parameters, by motion and parameter.

    Motions for which there is no room are left out.
    """
    ranges: dict[str, Ranges] = {}
    room = _down(home.amplitude)
    if room > SMALLEST:
        amplitude = min(room, max(WORTHWHILE, _down(SQUAT_SHARE * room)))
        height = max(round(room - amplitude, 3), SMALLEST)
        ranges["squat"] = {
            "amplitude": (SMALLEST, amplitude),
            "frequency": (SLOWEST, _fastest(home, amplitude)),
            "height": (-height, height),
        }
    for name, directions in (
        ("sway", ((0, 1), (0, -1))),
        ("lean", ((1, 0), (-1, 0))),
        ("circle", ((1, 0), (0, 1), (-1, 0), (0, -1))),
    ):
        farthest = min(_pressure_room(body, home, direction) for direction in directions)
        amplitude = _down(_largest(partial(_shifts, body, home, directions), farthest))
        if amplitude > SMALLEST:
            ranges[name] = {
                "amplitude": (SMALLEST, amplitude),
                "frequency": (SLOWEST, FASTEST_ASIDE),
            }
    turn = _down(_largest(partial(_turns, body, home), _twist_room(body, home)))
    if turn > SMALLEST:
        ranges["twist"] = {"amplitude": (SMALLEST, turn), "frequency": (SLOWEST, FASTEST_ASIDE)}
    return ranges


def _fastest(home: HomePosture, amplitude: float) -> float:
    """Compute the frequency at which torques and contact forces are still inside [Hz]."""
    share = max((each.share for each in home.family if each.is_good), default=home.posed.share)
    # torques grow with the weight: 10 % of it unknown, and what accelerates it
    lift = min(LIGHTEST, 1 / (1.1 * max(share, 1e-3)) - 1)
    frequency = math.sqrt(max(lift, 0.0) * 9.81 / amplitude) / (2 * math.pi)
    return max(min(FASTEST, math.floor(10 * frequency) / 10), 2 * SLOWEST)


def _pressure_room(body: Body, home: HomePosture, direction: tuple[int, int]) -> float:
    """Compute how far the centre of mass may swing until the pressure is at an edge [m]."""
    com = pinocchio.centerOfMass(body.model, body.model.createData(), home.posed.q)
    swing = 1 + (2 * math.pi * FASTEST_ASIDE) ** 2 * home.posed.height / 9.81
    corners = [
        place.act(np.array([x, y, 0.0]))[:2] - com[:2]
        for place, sole in zip(home.places, body.soles, strict=True)
        for x in sole.x
        for y in sole.y
    ]
    toward = np.array(corners) @ np.array(direction)
    room = float(toward.max()) - PRESSURE_MARGIN
    if direction[1]:
        middles = [
            place.act(np.array([np.mean(sole.x), np.mean(sole.y), 0.0]))[1]
            for place, sole in zip(home.places, body.soles, strict=True)
        ]
        room = min(room, UNLOADED * 0.5 * abs(middles[0] - middles[1]))
    return min(max(room / swing, 0.0), FARTHEST)


def _twist_room(body: Body, home: HomePosture) -> float:
    """Compute how far the upper body may turn until the soles slip [rad]."""
    model, data = body.model, body.model.createData()
    pinocchio.crba(model, data, home.posed.q)
    rotation = data.oMi[body.trunk].rotation
    moment = float((rotation @ data.Ycrb[body.trunk].inertia @ rotation.T)[2, 2])
    narrow = min(float(np.ptp(side)) for sole in body.soles for side in (sole.x, sole.y))
    bears = TORSION * narrow * body.mass * 9.81
    omega = 2 * math.pi * FASTEST_ASIDE
    return min(FARTHEST_TURN, TURNING_SHARE * bears / (moment * omega**2))


def _largest(can: Callable[[float], bool], farthest: float) -> float:
    """Find the largest size up to a farthest one that is possible, by halving."""
    if can(farthest):
        return farthest
    low, high = 0.0, farthest
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if can(middle) else (low, middle)
    return low


def _shifts(
    body: Body, home: HomePosture, directions: Sequence[tuple[int, int]], size: float
) -> bool:
    return all(
        _is_good(body, home, dataclasses.replace(wish, com=wish.com + np.array([*shift, sag])))
        for wish in [_wish(body, home)]
        for shift in size * np.array(directions, dtype=float)
        for sag in (-SAG, SAG)
    )


def _turns(body: Body, home: HomePosture, size: float) -> bool:
    wish = _wish(body, home)
    for angle in (-size, size):
        for sag in (-SAG, SAG):
            turn = pinocchio.exp3(np.array([0.0, 0.0, angle]))
            com = wish.com + np.array([0.0, 0.0, sag])
            turned = dataclasses.replace(wish, com=com, trunk=turn @ wish.trunk)
            if "rz" not in body.trunk_axes(home.posed.q):
                turned = dataclasses.replace(turned, pelvis=turn @ wish.pelvis)
            if not _is_good(body, home, turned):
                return False
    return True


def _wish(body: Body, home: HomePosture) -> Wish:
    com = np.array(pinocchio.centerOfMass(body.model, body.model.createData(), home.posed.q))
    pelvis, trunk = leaned(body, hang_arms(body), home.lean)
    return Wish(home.places, com, pelvis, trunk)


def _is_good(body: Body, home: HomePosture, wish: Wish) -> bool:
    q: Vector | None = settle(body, home.posed.q, home.posed.q, wish)
    if q is None or not pose(body, q).is_good:
        return False
    data = body.model.createData()
    pinocchio.forwardKinematics(body.model, data, q)
    off = pinocchio.log3(data.oMi[body.trunk].rotation.T @ wish.trunk)
    return float(np.linalg.norm(off)) < TURNED


def _down(value: float) -> float:
    """Round to millimetres or milliradians, down."""
    return max(math.floor(1e3 * value + 1e-6) / 1e3, 0.0)
