"""Where a robot believes its base to be, from its joint angles alone."""

from __future__ import annotations

from typing import Protocol

from tsd_casadi.robot.foot import Sole
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector
from tsd_clients.simulator.hardware import FlatFeetEstimator
from tsd_clients.simulator.still_points import StillPointsEstimator


class BaseEstimator(Protocol):
    """What the estimators for soles and for points have in common."""

    def estimate(self, angles: Vector, velocities: Vector) -> State:
        """Estimate the whole state."""


def make_base_estimator(robot: Robot, standing: State) -> BaseEstimator:
    """Make the estimator for a robot's kind of feet, all soles or all points.

    Args:
        standing: The posture whose feet are where they stand.
    """
    if all(isinstance(foot, Sole) for foot in robot.feet):
        return FlatFeetEstimator(robot, standing)
    return StillPointsEstimator(robot, standing)
