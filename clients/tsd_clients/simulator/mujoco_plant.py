"""The simulated robot as a controller meets it: measure, apply a torque, one step on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector
from tsd_clients.simulator.base_estimator import BaseEstimator, make_base_estimator
from tsd_clients.simulator.disturbances import Disturbance
from tsd_clients.simulator.effects import SENSOR_EFFECTS
from tsd_clients.simulator.hardware import Actuators, Encoders
from tsd_clients.simulator.state_map import StateMap


class MujocoPlant:
    """One simulated robot during one repetition.

    Attributes:
        com: True centre of mass of the last measurement, (3,) [m], world frame.
    """

    def __init__(
        self,
        robot: Robot,
        model: Any,
        start: State,
        standing: State,
        effects: Sequence[str],
        disturbances: Sequence[Disturbance],
        seed: int,
        substeps: int = 1,
    ) -> None:
        """Put the robot at its start.

        Args:
            model: ``mujoco.MjModel``.
            substeps: Steps of the simulation in one control period.
            standing: A posture with the soles where the robot believes them.
        """
        self._substeps, self._dt = substeps, float(model.opt.timestep)
        self._model = model
        self._data = mujoco.MjData(model)
        self._state_map = StateMap(robot, model)
        self._state_map.write(self._data, start)
        mujoco.mj_forward(model, self._data)
        self._disturbances = disturbances
        for disturbance in disturbances:
            disturbance.reset()
        self._actuators: Actuators | None = None
        self._encoders: Encoders | None = None
        self._estimator: BaseEstimator | None = None
        hardware = robot.description.hardware
        if effects and hardware is not None:
            self._actuators = Actuators(hardware, effects, self._dt)
            if any(effect in effects for effect in SENSOR_EFFECTS):
                rng = np.random.default_rng((seed, 1))
                self._encoders = Encoders(hardware, effects, self._dt, rng)
            if "flat_feet" in effects:
                self._estimator = make_base_estimator(robot, standing)
        self.com: Vector = np.array(self._data.subtree_com[self._state_map.base_body])

    def measure(self) -> tuple[State, State]:
        """Measure the state now.

        Returns:
            The true state, and the one that the robot's sensors tell.
        """
        true, sensed = self._sense()
        # a copy: the simulation overwrites its own
        self.com = self._data.subtree_com[self._state_map.base_body].copy()
        if sensed is None:
            return true, true
        angles, velocities = sensed
        if self._estimator is not None:
            return true, self._estimator.estimate(angles, velocities)
        measured = State(
            np.concatenate((true.q[:7], angles)), np.concatenate((true.v[:6], velocities))
        )
        return true, measured

    def step(self, tau: Vector, time: float) -> None:
        """Apply a torque for one control period.

        Args:
            tau: Commanded, (n,) [N m].
            time: Of the run [s].
        """
        for index in range(self._substeps):
            if index:
                # encoders and their filters run at the simulation's step
                self._sense()
            self._substep(tau, time + index * self._dt)

    def _sense(self) -> tuple[State, tuple[Vector, Vector] | None]:
        # positions and velocities first, so that the true centre of mass is the
        # one of the state that the controller is asked about
        mujoco.mj_step1(self._model, self._data)
        true = self._state_map.read(self._data)
        encoders = self._encoders
        return true, None if encoders is None else encoders.measure(true.q[7:], true.v[6:])

    def _substep(self, tau: Vector, time: float) -> None:
        data = self._data
        applied = tau if self._actuators is None else self._actuators.apply(tau)
        data.ctrl[self._state_map.actuators] = applied
        if self._disturbances:
            # each adds to what those before it wrote in this step
            data.xfrc_applied[:], data.qfrc_applied[:] = 0.0, 0.0
            for disturbance in self._disturbances:
                disturbance.apply(data, self._state_map, time)
        mujoco.mj_step2(self._model, data)

    def ground_force(self) -> tuple[Vector, Vector]:
        """Tell what the ground carried during the last step: true, of MuJoCo's contacts.

        To be asked between ``step`` and the next ``measure``.

        Returns:
            Total force (3,) [N] and its centre of pressure (2,) [m] in the plane
            z = 0, world frame; NaN where nothing touches the ground.
        """
        model, data = self._model, self._data
        force, moment, wrench = np.zeros(3), np.zeros(3), np.empty(6)
        for index in range(data.ncon):
            contact = data.contact[index]
            # MuJoCo's force is on the second geom; bodies welded to the world are ground
            first, second = model.body_weldid[model.geom_bodyid[contact.geom]] != 0
            if first == second:
                continue
            mujoco.mj_contactForce(model, data, index, wrench)
            axes = contact.frame.reshape(3, 3).T * (1.0 if second else -1.0)
            force += axes @ wrench[:3]
            moment += np.cross(contact.pos, axes @ wrench[:3]) + axes @ wrench[3:]
        if force[2] <= 0:
            return force, np.full(2, np.nan)
        return force, np.array([-moment[1], moment[0]]) / force[2]
