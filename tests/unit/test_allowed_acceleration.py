"""What the torque limits allow, against a linear program over the same robot."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from scipy.optimize import linprog

from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition import allowed_acceleration
from tsd_casadi.repetition.allowed_acceleration import allowed_accelerations
from tsd_casadi.robot.robot import Robot, load_robot

AXES = ("com.x", "com.y", "com.z")
SQUAT = Squat(0.03, 0.5)


@pytest.fixture(scope="module")
def hermes() -> Robot:
    return load_robot("hermes_lower")


def most(robot: Robot, axis: int, sign: float) -> float:
    """The largest acceleration along an axis with any torques inside their limits.

    The feet stand, glued; the other two axes of the centre of mass keep theirs.
    """
    model, q = robot.model, SQUAT.middle(robot).q
    data = model.createData()
    pinocchio.computeAllTerms(model, data, q, np.zeros(model.nv))
    M = np.triu(data.M) + np.triu(data.M, 1).T
    pinocchio.updateFramePlacements(model, data)
    Jc = np.vstack(
        [
            pinocchio.getFrameJacobian(model, data, frame, pinocchio.LOCAL)
            for frame in robot.sole_frames
        ]
    )
    J = pinocchio.jacobianCenterOfMass(model, data, q)
    nv, n, m = model.nv, robot.n, len(Jc)
    S = np.hstack([np.zeros((n, nv - n)), np.eye(n)])
    # accelerations, torques, wrenches, and the acceleration along the axis
    A = np.zeros((nv + m + 3, nv + n + m + 1))
    A[:nv, : nv + n + m] = np.hstack([M, -S.T, -Jc.T])
    A[nv : nv + m, :nv] = Jc
    A[nv + m :, :nv], A[nv + m + axis, -1] = J, -sign
    b = np.concatenate([-data.g, np.zeros(m + 3)])
    limit = np.minimum(robot.torque_limit, robot.stall_torque)
    free = [(None, None)]
    bounds = [*free * nv, *((-each, each) for each in limit), *free * m, (0, None)]
    cost = np.zeros(A.shape[1])
    cost[-1] = -1.0
    found = linprog(cost, A_eq=A, b_eq=b, bounds=bounds)
    assert found.success
    return float(found.x[-1])


@pytest.mark.parametrize("axis", range(3))
def test_no_more_is_allowed_than_any_torques_reach(
    hermes: Robot, axis: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    # one posture, that of the middle
    monkeypatch.setattr(allowed_acceleration, "PHASES", 1)
    allowed = allowed_accelerations(hermes, SQUAT, AXES)[axis]
    reached = min(most(hermes, axis, sign) for sign in (-1.0, 1.0))
    # torques of the smallest norm are not those that reach furthest, but no others by far
    assert 0.3 * reached < allowed <= reached * (1 + 1e-6)


def test_the_worst_posture_of_the_lap_counts(hermes: Robot) -> None:
    small, large = (allowed_accelerations(hermes, Squat(a, 0.5), AXES) for a in (0.005, 0.05))
    assert all(one >= other for one, other in zip(small, large, strict=True))


def test_half_of_the_limits_allows_about_half(
    hermes: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = allowed_accelerations(hermes, SQUAT, AXES)
    monkeypatch.setattr(hermes, "torque_limit", hermes.torque_limit / 2)
    monkeypatch.setattr(hermes, "stall_torque", hermes.stall_torque / 2)
    half = allowed_accelerations(hermes, SQUAT, AXES)
    # the weight takes its part first; the torques of the smallest norm are others
    assert all(0 < one < 0.55 * other for one, other in zip(half, whole, strict=True))
