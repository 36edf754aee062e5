r"""Which poses tell most about the height of the centre of mass.

Random references within the feet and what the legs reach become postures by
Newton steps; of these, one after another is taken that leaves the least

.. math:: \mathrm{tr} (T \Sigma_k T^T), \qquad
    \Sigma_k = \Sigma_{k-1} - \Sigma_{k-1} F^T (F \Sigma_{k-1} F^T + \sigma^2 I)^{-1} F \Sigma_{k-1}

with the pose's features F of the centre of pressure and those of the height T
at the lowest, the home and the highest standing posture: greedy A-optimal
design. So the first few poses of many are those that few would be.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.center_of_mass.fit import prior_correction
from tsd_casadi.center_of_mass.mass_prior import NOISE, MassPrior
from tsd_casadi.center_of_mass.static_chain import StaticChain
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_tasks import FrameTaskFile
from tsd_casadi.robot.standing import stand, standing_heights
from tsd_casadi.state import Matrix, State, Vector

MOST_POSES = 500
# candidates: at least so many, and so many for each pose asked for
CANDIDATES, CANDIDATES_PER_POSE = 300, 3
# part of the feet's extent, forward and sideways, that the centre of mass uses
SOLE_SHARE = 0.45
TILT = 0.35  # rad, about each axis of each orientation task
HOMING, STEPS, TOLERANCE = 0.2, 40, 1e-6  # as in standing.stand
LONGEST_STEP = 0.5  # rad
# distance from joint limits [rad]; least singular value, of home's, left to the
# tasks: straight knees have none
MARGIN, LEAST_MOBILITY = 0.05, 0.4
# singular value below which feet follow from each other, whatever the posture
DEPENDENT = 1e-3
DAMPING = 1e-9


def design_poses(robot: Robot, count: int, *, seed: int = 0) -> list[State]:
    """Choose the postures to measure the centre of pressure in.

    Returns:
        Postures at rest with the feet where they are at home, the most
        telling first.

    Raises:
        InvalidValue: If the count is out of range or the robot can hardly move.
    """
    if not 1 <= count <= MOST_POSES:
        raise InvalidValue("poses", count, f"1 to {MOST_POSES}")
    candidates = _Candidates(robot, seed).draw(max(CANDIDATES, CANDIDATES_PER_POSE * count))
    if len(candidates) < count:
        raise InvalidValue("poses", count, f"at most {len(candidates)} for {robot.name}")
    chain = StaticChain(robot)
    low, high = standing_heights(robot)
    T = np.vstack([chain.features(stand(robot, h).q)[2] for h in (low, 0.0, high)])
    F = np.array([chain.features(q)[:2] for q in candidates])
    covariance = prior_correction(robot, prior=MassPrior()).covariance
    chosen: list[int] = []
    for _ in range(count):
        S = F @ covariance @ F.transpose(0, 2, 1) + NOISE**2 * np.eye(2)
        A = F @ (covariance @ T.T)
        gain = np.einsum("kit,kit->k", A, np.linalg.solve(S, A))
        gain[chosen] = -np.inf
        best = int(np.argmax(gain))
        chosen.append(best)
        FC = F[best] @ covariance
        covariance = covariance - FC.T @ np.linalg.solve(S[best], FC)
    return [State(candidates[index], np.zeros(robot.nv)) for index in chosen]


class _Candidates:
    """Random postures within a robot's box of references."""

    def __init__(self, robot: Robot, seed: int) -> None:
        self._robot = robot
        self._model, self._data = robot.model, robot.model.createData()
        self._rng = np.random.default_rng((seed, 4))
        self._places = robot.sole_placements(robot.home.q)
        self._frames = [
            robot.frame_id(task.name)
            for task in robot.description.tasks
            if isinstance(task, FrameTaskFile) and {"rx", "ry", "rz"} <= set(task.axes)
        ]
        pinocchio.framesForwardKinematics(self._model, self._data, robot.home.q)
        self._upright = [self._data.oMf[frame].rotation.copy() for frame in self._frames]
        corners = np.vstack(
            [
                foot.corners(place)[:, :2]
                for foot, place in zip(robot.feet, self._places, strict=True)
            ]
        )
        lowest, highest = standing_heights(robot)
        forward, sideways = SOLE_SHARE * np.ptp(corners, axis=0) / 2
        self._low = np.array([-forward, -sideways, lowest])
        self._high = np.array([forward, sideways, highest])
        _, J = self._residual(robot.home.q, robot.home_com, self._upright)
        values = np.linalg.svd(J, compute_uv=False)
        self._independent = int(np.sum(values > DEPENDENT))
        self._mobility = float(values[self._independent - 1])

    def draw(self, count: int) -> list[Vector]:
        """Draw configurations, fewer than asked for where references are out of reach."""
        return [q for q in (self._one() for _ in range(count)) if q is not None]

    def _one(self) -> Vector | None:
        robot, rng = self._robot, self._rng
        com = robot.home_com + rng.uniform(self._low, self._high)
        tilted = [
            pinocchio.exp3(rng.uniform(-TILT, TILT, size=3)) @ upright for upright in self._upright
        ]
        q = robot.home.q.copy()
        for _ in range(STEPS):
            error, J = self._residual(q, com, tilted)
            if np.abs(error).max() < TOLERANCE:
                return q if self._is_safe(q, J) else None
            homeward = HOMING * pinocchio.difference(self._model, q, robot.home.q)
            gram = J @ J.T + DAMPING * np.eye(len(J))
            step = homeward + J.T @ np.linalg.solve(gram, error - J @ homeward)
            step *= min(1.0, LONGEST_STEP / np.abs(step).max())
            q = pinocchio.integrate(self._model, q, step)
        return None

    def _is_safe(self, q: Vector, J: Matrix) -> bool:
        low, high = self._model.lowerPositionLimit[7:], self._model.upperPositionLimit[7:]
        inside = ((low + MARGIN <= q[7:]) & (q[7:] <= high - MARGIN)).all()
        mobility = float(np.linalg.svd(J, compute_uv=False)[self._independent - 1])
        return bool(inside and mobility >= LEAST_MOBILITY * self._mobility)

    def _residual(self, q: Vector, com: Vector, rotations: list[Any]) -> tuple[Vector, Matrix]:
        model, data = self._model, self._data
        J_com = pinocchio.jacobianCenterOfMass(model, data, q).copy()
        pinocchio.computeJointJacobians(model, data, q)
        pinocchio.framesForwardKinematics(model, data, q)
        errors, jacobians = [com - data.com[0]], [J_com]
        for foot, place in zip(self._robot.feet, self._places, strict=True):
            errors.append(foot.error(data, place))
            jacobians.append(foot.jacobian(model, data))
        for frame, rotation in zip(self._frames, rotations, strict=True):
            errors.append(pinocchio.log3(data.oMf[frame].rotation.T @ rotation))
            J = pinocchio.getFrameJacobian(model, data, frame, pinocchio.LOCAL)
            jacobians.append(J[3:])
        return np.concatenate(errors), np.vstack(jacobians)
