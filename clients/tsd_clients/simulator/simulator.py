"""A MuJoCo simulation that asks a controller for torques at every tick."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import mujoco
import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue, RobotFileError
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.compensator import Compensator
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.repetition.repetition import Progress, Repetition
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State
from tsd_clients.simulator.disturbances import Disturbance
from tsd_clients.simulator.effects import check_effects
from tsd_clients.simulator.hardware import add_to_model
from tsd_clients.simulator.model_error import ModelError
from tsd_clients.simulator.mujoco_plant import TIMESTEP, MujocoPlant
from tsd_clients.simulator.parity import check_parity
from tsd_clients.simulator.state_map import StateMap

# starting posture: joints off home by up to this [rad], as in the paper's
# simulation, which "has a small starting randomness built-in"
START_NOISE = 2e-3
UNCHANGED = Gains()


class MujocoSimulator:
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
    ) -> None:
        """Load the scene and check it against the URDF.

        Args:
            model_error: E of every link, greater than -1, or errors that differ.
            hardware: Effects that count, from ``tsd_clients.simulator.hardware.EFFECTS``,
                or 'all'; none by default.

        Raises:
            RobotFileError: If the scene cannot be used.
            ParityError: If scene and URDF describe different bodies.
            InvalidValue: If the model error is out of range or an effect unknown.
        """
        if not isinstance(model_error, ModelError):
            model_error = ModelError(model_error)
        self.hardware = check_effects(robot, hardware)
        try:
            model: Any = mujoco.MjModel.from_xml_path(str(robot.scene_path))
        except ValueError as error:
            raise RobotFileError(
                robot.scene_path, "", f"cannot be loaded ({error})", "a MuJoCo scene"
            ) from error
        check_parity(robot, model)
        model.opt.timestep = TIMESTEP
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
        self.model = model
        self.model_error = model_error
        self.state_map = state_map

    def __repr__(self) -> str:
        """Name the robot and how the simulated one differs from it."""
        error = self.model_error
        effects = ", ".join(self.hardware) or "none"
        return (
            f"<MujocoSimulator of {self.robot.name}: model error {error.uniform:g}, by link "
            f"{error.per_link:g}; hardware {effects}>"
        )

    def start(self, posture: State, seed: int = 0) -> State:
        """Put a posture's joints off by a little, the soles on the ground on average."""
        rng = np.random.default_rng(seed)
        q = posture.q.copy()
        q[7:] += rng.uniform(-START_NOISE, START_NOISE, size=self.robot.n)
        return State(self.robot.put_on_ground(q), posture.v)

    def run(
        self,
        controller: WholeBodyController,
        motion: Motion,
        *,
        laps: int = 3,
        feedforward: Feedforward | None = None,
        gains: Gains = UNCHANGED,
        compensators: Sequence[Compensator] = (),
        disturbances: Sequence[Disturbance] = (),
        seed: int = 0,
        transport: str = "local",
        progress: Progress | None = None,
    ) -> Run:
        """Simulate one repetition in lock-step with a controller.

        The robot holds the middle of the motion for one second with the
        feedforward of the starting phase, then moves. Laps are added until two
        consecutive ones agree, up to a bound.

        Args:
            laps: Least number of laps.
            feedforward: Learned term; none by default.
            gains: Factors on the learned task's gains.
            seed: Of the starting posture and of the sensors' noise.
            transport: How the controller is reached, for the records.
            progress: Called with (done, total) seconds of simulated time.

        Returns:
            The run.

        Raises:
            InvalidValue: If motion or settings are out of range.
            SimulationError: If the controller serves another robot.
        """
        motion.check(self.robot)
        if laps < 2:
            raise InvalidValue("laps", laps, "at least 2, the first one settles")
        middle = motion.middle(self.robot)
        plant = MujocoPlant(
            self.robot,
            self.model,
            self.start(middle, seed),
            middle,
            self.hardware,
            disturbances,
            seed,
        )
        repetition = Repetition(
            self.robot, plant, controller, motion, feedforward, gains, compensators
        )
        repetition.hold(progress)
        repetition.move(laps, progress)
        settings = {
            **self.model_error.settings(),
            "hardware": list(self.hardware),
            "p_scale": gains.P,
            "d_scale": gains.D,
            "transport": transport,
            "seed": seed,
        }
        return repetition.finish(settings)
