r"""What a real robot has and rigid bodies with perfect sensors have not.

Actuators: reflected inertia, viscous and Coulomb friction, a delay and a
first-order lag of the torque. Sensors: joint encoders with steps and noise,
velocities by differencing and a low pass, and the base's pose from the joint
angles with both feet assumed flat where they stood at the start. Numbers come
from the robot file, every effect is switched by name.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection
from typing import Any

import numpy as np
import pinocchio
from scipy.linalg.lapack import dposv

from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import HardwareFile
from tsd_casadi.state import State, Vector


class Actuators:
    """From commanded to applied torque."""

    def __init__(self, hardware: HardwareFile, effects: Collection[str], dt: float) -> None:
        """Start with nothing applied yet.

        Args:
            dt: Time step [s].
        """
        delay = round(hardware.torque_delay / dt) if "delay" in effects else 0
        self._queue: deque[Vector] = deque(maxlen=delay + 1)
        self._share = _share(hardware.torque_lag if "lag" in effects else 0.0, dt)
        self._applied: Vector | None = None

    def apply(self, tau: Vector) -> Vector:
        """Compute what the joints feel of a command one step long.

        Args:
            tau: Commanded torque, (n,) [N m].

        Returns:
            Applied torque at the end of the step, (n,) [N m].
        """
        self._queue.append(tau.copy())
        late = self._queue[0]
        if self._applied is None or self._share == 1.0:
            # the first command has been there for long: the robot stands
            self._applied = late
        else:
            self._applied = self._applied + self._share * (late - self._applied)
        return self._applied


class Encoders:
    """From true to measured joint angles and velocities."""

    def __init__(
        self,
        hardware: HardwareFile,
        effects: Collection[str],
        dt: float,
        rng: np.random.Generator,
    ) -> None:
        """Start without a measurement.

        Args:
            dt: Time step [s].
        """
        self._step = hardware.encoder_resolution if "quantisation" in effects else 0.0
        self._noise = hardware.encoder_noise if "noise" in effects else 0.0
        self._differencing = "differencing" in effects
        self._share = _share(hardware.velocity_filter, dt)
        self._dt = dt
        self._rng = rng
        self._last: Vector | None = None
        self._velocity: Vector | None = None

    def measure(self, angles: Vector, velocities: Vector) -> tuple[Vector, Vector]:
        """Measure joint angles and velocities once.

        Args:
            angles: True joint angles, (n,) [rad].
            velocities: True joint velocities, (n,) [rad/s].

        Returns:
            Measured angles and velocities, (n,) each.
        """
        measured = angles
        if self._noise > 0.0:
            measured = measured + self._noise * self._rng.standard_normal(len(angles))
        if self._step > 0.0:
            measured = self._step * np.rint(measured / self._step)
        if not self._differencing:
            return measured, velocities
        if self._last is None or self._velocity is None:
            # it has moved like that for long
            self._velocity = velocities
        else:
            difference = (measured - self._last) / self._dt
            self._velocity = self._velocity + self._share * (difference - self._velocity)
        self._last = measured
        return measured, self._velocity


class FlatFeetEstimator:
    r"""Base pose and velocity from joint angles, the feet standing still and flat.

    A foot at X in the base's frame that stands at S in the world puts the base
    at S X^-1. Seen from a base at rest the feet move with twists w; the base
    moves with the twist b that moves them least,

    .. math:: \min_b \sum_i \|Ad_i b + w_i\|^2

    with w_i and Ad_i b in the frame of foot i, metres and radians alike.
    """

    def __init__(self, robot: Robot, standing: State) -> None:
        """Note where the feet stand.

        Args:
            standing: The posture whose soles are the true ones.
        """
        self._model, self._data = robot.model, robot.model.createData()
        self._feet = list(zip(robot.sole_frames, robot.sole_placements(standing.q), strict=True))
        # as if the base were at the world's origin, at rest
        self._q, self._v = pinocchio.neutral(self._model), np.zeros(robot.nv)
        self._Ad = np.zeros((6 * len(self._feet), 6))
        self._w = np.zeros(6 * len(self._feet))

    def estimate(self, angles: Vector, velocities: Vector) -> State:
        """Estimate the whole state.

        Args:
            angles: Joint angles, (n,) [rad].
            velocities: Joint velocities, (n,) [rad/s].

        Returns:
            Mean of what each foot says about the base; the base velocity that
            moves the soles least.
        """
        model, data = self._model, self._data
        self._q[7:], self._v[6:] = angles, velocities
        pinocchio.forwardKinematics(model, data, self._q, self._v)
        base = None
        for foot, (frame, sole) in enumerate(self._feet):
            inverse = pinocchio.updateFramePlacement(model, data, frame).inverse()
            seen = sole * inverse
            base = seen if base is None else pinocchio.SE3.Interpolate(base, seen, 1 / (foot + 1))
            rows = slice(6 * foot, 6 * foot + 6)
            self._Ad[rows] = inverse.action
            self._w[rows] = pinocchio.getFrameVelocity(model, data, frame, pinocchio.LOCAL).vector
        # LAPACK itself: numpy's solve spends most of its time on the way there
        Ad_T = self._Ad.T
        _, b, _ = dposv(Ad_T.dot(self._Ad), -Ad_T.dot(self._w))
        return State(
            np.concatenate((pinocchio.SE3ToXYZQUAT(base), angles)),
            np.concatenate((b, velocities)),
        )


def _share(time_constant: float, dt: float) -> float:
    """Compute how far a first-order lag goes in one step, exactly: 1 - exp(-dt / T)."""
    return 1.0 if time_constant == 0.0 else 1 - math.exp(-dt / time_constant)


def add_to_model(
    model: Any, joints: Vector, hardware: HardwareFile, effects: Collection[str]
) -> None:
    """Give a simulated robot's joints their inertia and friction.

    Args:
        model: ``mujoco.MjModel``, changed.
        joints: Index of each joint in MuJoCo's velocity, (n,).
    """
    if "armature" in effects:
        model.dof_armature[joints] += hardware.armature
    if "friction" in effects:
        model.dof_damping[joints] += hardware.viscous_friction
        model.dof_frictionloss[joints] += hardware.coulomb_friction
