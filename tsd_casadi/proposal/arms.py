"""How arms hang: low, away from their joints' limits, and how far they sag."""

from __future__ import annotations

from functools import cache

import numpy as np
import pinocchio

from tsd_casadi.proposal.body import Body
from tsd_casadi.state import Vector

# distance that an arm's joint likes to keep from a limit, and its largest share of the
# joint's range: an elbow at its stop bends by as much [rad]
COMFORT, COMFORT_SHARE = 0.4, 0.3
# waist and neck are straight where that leaves so much [rad]
UPRIGHT_MARGIN = 0.2
# a limb whose centre of mass is this share of the robot's height off the sagittal plane is
# an arm and hangs; a neck stays upright
ASIDE = 0.03
# of angles from zero, against heights in shares of the arm's reach
NEUTRAL = 0.02


@cache
def hang_arms(body: Body) -> Vector:
    """Find angles for all joints above the hips.

    Returns:
        Configuration, (nq,): arms hanging with their joints away from the limits,
        everything else as near to zero as the limits allow, upright.
    """
    from scipy.optimize import minimize

    model, data = body.model, body.model.createData()
    q = body.neutral()
    comfort = np.minimum(COMFORT, COMFORT_SHARE * (body.high - body.low))
    waist_and_neck = np.array([model.joints[j].idx_q for j in (*body.arms, *body.waist)], dtype=int)
    room = np.minimum(UPRIGHT_MARGIN, COMFORT_SHARE * (body.high - body.low))
    nearest = np.clip(0.0, body.low + room, body.high - room)
    q[waist_and_neck] = nearest[waist_and_neck - 7]
    arms = np.array([model.joints[j].idx_q for j in hanging(body)], dtype=int)
    if not len(arms):
        return q
    low, high, wanted = body.low[arms - 7], body.high[arms - 7], comfort[arms - 7]
    pinocchio.centerOfMass(model, data, q)
    mass = sum(data.mass[j] for j in hanging(body) if model.parents[j] not in hanging(body))
    lever = mass * 9.81 * body_height(body, q) / 4  # an arm is about a quarter as long

    def cost(angles: Vector) -> float:
        posture = q.copy()
        posture[arms] = angles
        height = float(pinocchio.computePotentialEnergy(model, data, posture)) / lever
        lacking = np.maximum(0.0, wanted - np.minimum(angles - low, high - angles)) / wanted
        return float(height + lacking @ lacking + NEUTRAL * angles @ angles)

    found = minimize(cost, q[arms], method="L-BFGS-B", bounds=list(zip(low, high, strict=True)))
    q[arms] = found.x
    return q


def hanging(body: Body) -> list[int]:
    """List the joints of arms: of limbs off the sagittal plane."""
    model, data = body.model, body.model.createData()
    q = body.neutral()
    pinocchio.centerOfMass(model, data, q)
    middle = _middle(body, q)
    chosen = set()
    for j in body.arms:
        # a limb begins where the trunk's tree leaves the plane
        point = data.oMi[j].act(data.com[j])
        if abs(point[1] - middle) > ASIDE * body_height(body, q):
            chosen.add(j)
    return sorted(chosen)


def sag(body: Body, q: Vector, model_error: float, stiffness: float) -> Vector:
    r"""Compute how far joints sag that only the posture holds.

    .. math:: \delta = \epsilon M_{aa}^{-1} g_a / P_q

    Args:
        q: Configuration, (nq,).
        model_error: Share of the gravity torques that nobody accounts for.
        stiffness: P_q of the posture [1/s^2].

    Returns:
        (n,) [rad], zero for joints of legs and waist, whose tasks hold them.
    """
    model, data = body.model, body.model.createData()
    rows = np.array([model.joints[j].idx_v for j in body.arms], dtype=int)
    sagged = np.zeros(body.n)
    if len(rows):
        M = np.array(pinocchio.crba(model, data, q))
        M = np.triu(M) + np.triu(M, 1).T
        g = np.array(pinocchio.computeGeneralizedGravity(model, data, q))
        bent = np.linalg.solve(M[np.ix_(rows, rows)], g[rows])
        sagged[rows - 6] = model_error * np.abs(bent) / stiffness
    return sagged


def body_height(body: Body, q: Vector) -> float:
    """Compute the height of the centre of mass above the soles [m]."""
    model, data = body.model, body.model.createData()
    pinocchio.framesForwardKinematics(model, data, q)
    com = pinocchio.centerOfMass(model, data, q)
    ground = np.mean([data.oMf[frame].translation[2] for frame in body.sole_frames])
    return float(com[2] - ground)


def _middle(body: Body, q: Vector) -> float:
    model, data = body.model, body.model.createData()
    pinocchio.framesForwardKinematics(model, data, q)
    return float(np.mean([data.oMf[frame].translation[1] for frame in body.sole_frames]))
