"""A MuJoCo simulation that asks a controller for torques at every tick."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pinocchio

from tsd_casadi import State
from tsd_casadi.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue, RobotFileError
from tsd_casadi.feedforward import Feedforward
from tsd_casadi.motions import Motion
from tsd_casadi.robot import Robot
from tsd_clients.mujoco_state import StateMap
from tsd_clients.parity import check_parity
from tsd_clients.repetition import TIMESTEP, Progress, Repetition
from tsd_clients.run import Run

# starting posture: joints off home by up to this [rad], as in the paper's
# simulation, which "has a small starting randomness built-in"
START_NOISE = 2e-3


class MujocoSimulator:
    """The simulated robot, with a body that the controller need not know.

    Attributes:
        robot: The robot as its files describe it.
        model: ``mujoco.MjModel`` with the model error applied.
        model_error: E; the controller's masses and inertias are 1 + E times
            the simulated robot's.
        state_map: Conversion between the conventions of scene and robot.
    """

    def __init__(self, robot: Robot, model_error: float = 0.0) -> None:
        """Load the scene and check it against the URDF.

        Args:
            robot: The robot.
            model_error: E, greater than -1.

        Raises:
            RobotFileError: If the scene cannot be used.
            ParityError: If scene and URDF describe different bodies.
            InvalidValue: If the model error is out of range.
        """
        if not -0.9 <= model_error <= 9.0:
            raise InvalidValue("model error", model_error, "a fraction from -0.9 to 9, 0.1 is 10 %")
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
        model.body_mass[:] /= 1 + model_error
        model.body_inertia[:] /= 1 + model_error
        mujoco.mj_setConst(model, mujoco.MjData(model))
        self.robot = robot
        self.model = model
        self.model_error = model_error
        self.state_map = StateMap(robot, model)

    def start(self, seed: int = 0) -> Any:
        """A fresh ``mujoco.MjData`` at home, joints off by a little.

        Args:
            seed: Of the starting randomness.
        """
        rng = np.random.default_rng(seed)
        home = self.robot.home
        q = home.q.copy()
        q[7:] += rng.uniform(-START_NOISE, START_NOISE, size=self.robot.n)
        model, pin_data = self.robot.model, self.robot.model.createData()
        pinocchio.framesForwardKinematics(model, pin_data, q)
        frames = [model.getFrameId(contact.frame) for contact in self.robot.description.contacts]
        q[2] -= np.mean([pin_data.oMf[frame].translation[2] for frame in frames])
        data = mujoco.MjData(self.model)
        self.state_map.write(data, State(q, home.v))
        mujoco.mj_forward(self.model, data)
        return data

    def run(
        self,
        controller: WholeBodyController,
        motion: Motion,
        *,
        laps: int = 3,
        feedforward: Feedforward | None = None,
        p_scale: float = 1.0,
        seed: int = 0,
        transport: str = "local",
        progress: Progress | None = None,
    ) -> Run:
        """Simulate one repetition in lock-step with a controller.

        The robot holds home for one second with the feedforward of the
        starting phase, then moves. Laps are added until two consecutive ones
        agree, up to a bound.

        Args:
            controller: Local or remote.
            motion: What to do.
            laps: Least number of laps.
            feedforward: Learned term; none by default.
            p_scale: Factor on the learned task's P; D stays.
            seed: Of the starting randomness.
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
        if not 0 < p_scale <= 100:
            raise InvalidValue("p scale", p_scale, "a factor above 0, up to 100")
        data = self.start(seed)
        repetition = Repetition(
            self.robot, self.model, data, controller, motion, feedforward, p_scale
        )
        repetition.hold(progress)
        repetition.move(laps, progress)
        settings = {
            "model_error": self.model_error,
            "p_scale": p_scale,
            "transport": transport,
            "seed": seed,
        }
        return repetition.finish(settings)
