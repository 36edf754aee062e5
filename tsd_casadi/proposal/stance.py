r"""Stand on both soles with the centre of mass somewhere: bounded Gauss-Newton steps.

Each step solves

.. math::

    \min_{\Delta q} \; |W (J \Delta q - e)|^2 + |w_q (q_{pref} \ominus q - \Delta q)|^2
    \quad \text{with} \quad q_{low} \le q + \Delta q \le q_{high}

where e stacks the soles' poses, the centre of mass, the rotations of pelvis and
trunk and, where asked for, the bend of the knees.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.proposal.body import Body
from tsd_casadi.state import Matrix, Vector

# what holds exactly, against what is wished for
SOLES, COM, PELVIS, TRUNK, KNEES, POSTURE = 1e3, 3e2, 1e3, 10.0, 30.0, 0.1
STEPS = 40
# largest step: beyond, the linearisation is worth nothing [rad, m]
LARGEST_STEP = 0.4
TOLERANCE = 1e-7
# steps without getting nearer by a hundredth
PATIENCE, NEARER = 6, 0.99
# soles and centre of mass are where they should be [m, rad]
REACHED = 2e-4


@dataclass(frozen=True)
class Wish:
    """How to stand.

    Attributes:
        places: Of the left and of the right sole's frame, world frame.
        com: (3,) [m], world frame; NaN where it is free.
        pelvis: Rotation of the link that carries the legs, (3, 3).
        trunk: Rotation of the trunk, (3, 3).
        bend: Of both knees [rad], or None if the height of the centre of mass says it.
    """

    places: tuple[Any, Any]
    com: Vector
    pelvis: Matrix
    trunk: Matrix
    bend: float | None = None


def settle(body: Body, start: Vector, preferred: Vector, wish: Wish) -> Vector | None:
    """Find a configuration as wished.

    Args:
        start: Configuration to start from, (nq,).
        preferred: Configuration to stay near, (nq,).

    Returns:
        (nq,), or None if soles and centre of mass cannot be where they should inside
        the joints' limits.
    """
    model, data = body.model, body.model.createData()
    low, high = body.low, body.high
    q = start.copy()
    q[7:] = np.clip(q[7:], low, high)
    weights = np.full(model.nv, POSTURE)
    weights[:6] = 1e-6
    best, waited = np.inf, 0
    for _ in range(STEPS):
        error, J = _residual(body, data, q, wish)
        # a posture that is out of reach shows by getting no nearer
        missed = float(np.linalg.norm(error))
        best, waited = (missed, 0) if missed < NEARER * best else (best, waited + 1)
        if waited > PATIENCE and _hard(error) > REACHED:
            break
        away = pinocchio.difference(model, q, preferred)
        free = np.full(6, LARGEST_STEP)
        lower = np.concatenate((-free, np.maximum(low - q[7:], -LARGEST_STEP)))
        upper = np.concatenate((free, np.minimum(high - q[7:], LARGEST_STEP)))
        gram = J.T @ J + np.diag(weights**2)
        step = _bounded_step(gram, J.T @ error + weights**2 * away, lower, upper)
        q = pinocchio.integrate(model, q, step)
        if np.abs(step).max() < TOLERANCE:
            break
    error, _ = _residual(body, data, q, wish)
    return q if _hard(error) < REACHED else None


def sole_places(body: Body, width: float) -> tuple[Any, Any]:
    """Place both soles side by side, the middles of their rectangles on the world's y axis.

    Args:
        width: Between those middles [m].
    """
    left, right = (
        pinocchio.SE3(
            np.eye(3), np.array([-np.mean(sole.x), side * width / 2 - np.mean(sole.y), 0])
        )
        for sole, side in zip(body.soles, (1.0, -1.0), strict=True)
    )
    return left, right


def _hard(error: Vector) -> float:
    """Compute how far soles and centre of mass are off at most [m, rad]."""
    return float(np.abs(np.concatenate((error[:12] / SOLES, error[12:15] / COM))).max())


def _bounded_step(gram: Matrix, gradient: Vector, lower: Vector, upper: Vector) -> Vector:
    """Minimise a quadratic in a box: what leaves the box is held at its face."""
    step = np.zeros(len(gradient))
    free = np.ones(len(gradient), dtype=bool)
    while free.any():
        rest = gradient - gram @ np.where(free, 0.0, step)
        step[free] = np.linalg.solve(gram[np.ix_(free, free)], rest[free])
        beyond = np.maximum(step - upper, lower - step)
        outside = free & (beyond > 0)
        if not outside.any():
            break
        step[outside] = np.clip(step, lower, upper)[outside]
        free &= ~outside
    return step


def _residual(body: Body, data: Any, q: Vector, wish: Wish) -> tuple[Vector, Matrix]:
    model = body.model
    J_com = pinocchio.jacobianCenterOfMass(model, data, q)
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.framesForwardKinematics(model, data, q)
    errors, jacobians = [], []
    for frame, place in zip(body.sole_frames, wish.places, strict=True):
        errors.append(SOLES * pinocchio.log6(data.oMf[frame].actInv(place)).vector)
        J = pinocchio.getFrameJacobian(model, data, frame, pinocchio.LOCAL)
        jacobians.append(SOLES * np.array(J))
    known = np.isfinite(wish.com)
    errors.append(COM * np.where(known, wish.com - data.com[0], 0.0))
    jacobians.append(COM * known[:, None] * J_com)
    links = ((body.pelvis, wish.pelvis, PELVIS), (body.trunk, wish.trunk, TRUNK))
    for joint, rotation, weight in links:
        errors.append(weight * pinocchio.log3(data.oMi[joint].rotation.T @ rotation))
        J = pinocchio.getJointJacobian(model, data, joint, pinocchio.LOCAL)
        jacobians.append(weight * np.array(J[3:]))
    if wish.bend is not None:
        for leg in body.legs:
            errors.append(np.array([KNEES * leg.sign * (wish.bend - leg.bend(model, q))]))
            row = np.zeros((1, model.nv))
            row[0, model.joints[leg.knee].idx_v] = KNEES
            jacobians.append(row)
    return np.concatenate(errors), np.vstack(jacobians)
