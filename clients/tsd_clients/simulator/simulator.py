"""A MuJoCo simulation that asks a controller for torques at every tick."""

from __future__ import annotations

import copy
import math
from collections.abc import Collection, Sequence
from typing import Any

import mujoco
import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.plant import Plant, Truth
from tsd_casadi.repetition.repeat import repeat
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector
from tsd_clients.simulator.disturbances import Disturbance
from tsd_clients.simulator.effects import check_effects
from tsd_clients.simulator.hardware import add_to_model
from tsd_clients.simulator.model_error import ModelError
from tsd_clients.simulator.mujoco_plant import MujocoPlant
from tsd_clients.simulator.parity import check_parity
from tsd_clients.simulator.scene import load_scene
from tsd_clients.simulator.state_map import StateMap

# starting posture: joints off home by up to this [rad], as in the paper's
# simulation, which "has a small starting randomness built-in"
START_NOISE = 2e-3
# of a control period: a simulator may step finer, not coarser [s]
LARGEST_STEP = 1e-3
SHORTEST_PERIOD, LONGEST_PERIOD = 0.25e-3, 5e-3  # s


class MujocoSimulator(Plant):
    """The simulated robot, with a body that the controller need not know.

    Attributes:
        robot: The robot as its files describe it.
        model: ``mujoco.MjModel`` with the model error applied.
        model_error: How far the controller's masses and inertias are from the
            simulated robot's.
        hardware: Names of the hardware effects that count.
        state_map: Conversion between the conventions of scene and robot.
    """

    def __init__(
        self,
        robot: Robot,
        model_error: float | ModelError = 0.0,
        hardware: Collection[str] = (),
        *,
        period: float = 1e-3,
        disturbances: Sequence[Disturbance] = (),
    ) -> None:
        """Load the scene or build one, and check it against the robot.

        Args:
            model_error: E of every link, greater than -1, or errors that differ.
            hardware: Effects that count, from ``tsd_clients.simulator.hardware.EFFECTS``,
                or 'all'; none by default.
            period: Control period [s].
            disturbances: What pushes the robot.

        Raises:
            RobotFileError: If the scene cannot be used.
            ParityError: If scene and robot differ in what counts.
            InvalidValue: If the model error is out of range or an effect unknown.
        """
        if not isinstance(model_error, ModelError):
            model_error = ModelError(model_error)
        self.hardware = check_effects(robot, hardware)
        model = load_scene(robot)
        check_parity(robot, model)
        if not SHORTEST_PERIOD <= period <= LONGEST_PERIOD:
            raise InvalidValue(
                "period", f"{period:g} s", f"{SHORTEST_PERIOD:g} to {LONGEST_PERIOD:g} s"
            )
        self._substeps = math.ceil(period / LARGEST_STEP - 1e-9)
        model.opt.timestep = period / self._substeps
        # positions, then velocities, then forces: what mj_step1 and mj_step2 do
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
        # a simulation that blew up is a fall, not a new start
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        state_map = StateMap(robot, model)
        # the world's body comes first and has no mass
        factors = np.concatenate(([1.0], model_error.factors(model.nbody - 1)))
        model.body_mass[:] /= factors
        model.body_inertia[:] /= factors[:, None]
        numbers = robot.description.hardware
        if numbers is not None:
            add_to_model(model, state_map.v_joints, numbers, self.hardware)
        mujoco.mj_setConst(model, mujoco.MjData(model))
        self.robot = robot
        self.period = period
        # semi-implicit: velocities are those of the middle of the last step
        self.velocity_time = -0.5 * float(model.opt.timestep)
        self.model = model
        self.model_error = model_error
        self.state_map = state_map
        self.disturbances = tuple(disturbances)
        self._body: MujocoPlant | None = None
        self._truth: Truth | None = None
        self._ticks = 0

    def __repr__(self) -> str:
        """Name the robot and how the simulated one differs from it."""
        error = self.model_error
        effects = ", ".join(self.hardware) or "none"
        return (
            f"<MujocoSimulator of {self.robot.name}: model error {error.uniform:g}, by link "
            f"{error.per_link:g}; hardware {effects}>"
        )

    def with_disturbances(self, disturbances: Sequence[Disturbance]) -> MujocoSimulator:
        """Give the same simulated robot, pushed."""
        other = copy.copy(self)
        other.disturbances = tuple(disturbances)
        return other

    def near(self, posture: State, seed: int = 0) -> State:
        """Put a posture's joints off by a little, the soles on the ground on average.

        Args:
            posture: What it is near to.
            seed: Of the starting posture.
        """
        rng = np.random.default_rng(seed)
        q = posture.q.copy()
        q[7:] += rng.uniform(-START_NOISE, START_NOISE, size=self.robot.n)
        return State(self.robot.put_on_ground(q), posture.v)

    def body(self, start: State, standing: State, seed: int = 0) -> MujocoPlant:
        """Make the simulated robot at the beginning of a repetition.

        Args:
            start: Where it is.
            standing: A posture with the soles where the robot believes them.
            seed: Of the sensor noise.
        """
        return MujocoPlant(
            self.robot,
            self.model,
            start,
            standing,
            self.hardware,
            self.disturbances,
            seed,
            self._substeps,
        )

    def start(self, posture: State, seed: int = 0) -> None:
        """Put the robot near a posture, at rest.

        Args:
            posture: Soles flat.
            seed: Of the starting posture and of the sensors' noise.
        """
        self._body, self._ticks = self.body(self.near(posture, seed), posture, seed), 0

    def measure(self) -> State:
        """Read the state as the sensors tell it now."""
        assert self._body is not None
        true, measured = self._body.measure()
        self._truth = Truth(true, self._body.com)
        return measured

    def truth(self) -> Truth | None:
        """Tell the state of the simulation at the last measurement."""
        return self._truth

    def apply(self, tau: Vector) -> None:
        """Go on by one control period.

        Args:
            tau: Commanded, (n,) [N m].
        """
        assert self._body is not None
        self._body.step(tau, self._ticks * self.period)
        self._ticks += 1

    def settings(self) -> dict[str, Any]:
        """Describe model errors and hardware effects."""
        return {**self.model_error.settings(), "hardware": list(self.hardware)}

    def run(
        self,
        controller: WholeBodyController,
        motion: Motion,
        *,
        disturbances: Sequence[Disturbance] = (),
        **options: Any,
    ) -> Run:
        """Simulate one repetition in lock-step with a controller.

        Args:
            disturbances: What pushes the robot, besides what pushes it anyway.
            options: As of ``repeat``.
        """
        plant = self.with_disturbances((*self.disturbances, *disturbances))
        return repeat(plant, controller, motion, **options)
