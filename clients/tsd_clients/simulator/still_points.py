r"""Base pose and velocity of a robot on points, from its joint angles.

Points at p_i in the base's frame that stand at s_i in the world tell the base's
pose R, t by

.. math:: \min_{R, t} \sum_i \|R p_i + t - s_i\|^2

with R from the singular values of their covariance (S. Umeyama, Least-squares
estimation of transformation parameters between two point patterns, IEEE PAMI
1991). It takes three points that are not in line. That a ball rolls on while its
leg turns is not in it, as it is not on a real robot.
"""

from __future__ import annotations

import numpy as np
import pinocchio
from scipy.linalg.lapack import dposv

from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector


class StillPointsEstimator:
    """Base pose and velocity from joint angles, the points standing still."""

    def __init__(self, robot: Robot, standing: State) -> None:
        """Note where the points stand.

        Args:
            standing: The posture whose points are the true ones.
        """
        self._model, self._data = robot.model, robot.model.createData()
        self._frames = robot.sole_frames
        places = robot.sole_placements(standing.q)
        self._standing = np.array([place.translation for place in places])
        self._middle = self._standing.mean(axis=0)
        # as if the base were at the world's origin, at rest
        self._q, self._v = pinocchio.neutral(self._model), np.zeros(robot.nv)
        self._J = np.tile(np.eye(3, 6), (len(self._frames), 1))
        self._w = np.zeros(3 * len(self._frames))

    def estimate(self, angles: Vector, velocities: Vector) -> State:
        """Estimate the whole state.

        Args:
            angles: Joint angles, (n,) [rad].
            velocities: Joint velocities, (n,) [rad/s].

        Returns:
            The base pose with the points nearest to where they stand; the base
            velocity that moves them least.
        """
        model, data = self._model, self._data
        self._q[7:], self._v[6:] = angles, velocities
        pinocchio.forwardKinematics(model, data, self._q, self._v)
        seen = np.empty_like(self._standing)
        for i, frame in enumerate(self._frames):
            seen[i] = pinocchio.updateFramePlacement(model, data, frame).translation
            rows = slice(3 * i, 3 * i + 3)
            # a turn of the base by w moves the point by w x p
            self._J[rows, 3:] = -pinocchio.skew(seen[i])
            aligned = pinocchio.LOCAL_WORLD_ALIGNED
            self._w[rows] = pinocchio.getFrameVelocity(model, data, frame, aligned).linear
        middle = seen.mean(axis=0)
        U, _, Vt = np.linalg.svd((self._standing - self._middle).T @ (seen - middle))
        U[:, 2] *= np.sign(np.linalg.det(U) * np.linalg.det(Vt))  # no reflection
        R = U @ Vt
        base = pinocchio.SE3(R, self._middle - R @ middle)
        # LAPACK itself: numpy's solve spends most of its time on the way there
        _, b, _ = dposv(self._J.T.dot(self._J), -self._J.T.dot(self._w))
        return State(
            np.concatenate((pinocchio.SE3ToXYZQUAT(base), angles)),
            np.concatenate((b, velocities)),
        )
