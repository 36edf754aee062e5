"""The simulated robot with fresh noise in each repetition, and one that changes between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from tsd_casadi.repetition.plant import Plant, Truth
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State, Vector
from tsd_clients.simulator.disturbances import Disturbance, TorqueNoise
from tsd_clients.simulator.simulator import MujocoSimulator

MODEL_ERROR = 0.1
HARDWARE = ("all",)


class FreshTorqueNoise(TorqueNoise):
    """White noise on every joint torque, another one in each run.

    Attributes:
        runs: How many have begun.
    """

    runs = 0

    def reset(self) -> None:
        """Start the noise of the next run."""
        self._rng = np.random.default_rng((self.seed, 2, self.runs))
        self.runs += 1


def make_robot(
    robot: Robot,
    model_error: float = MODEL_ERROR,
    load: float = 0.0,
    disturbances: Sequence[Disturbance] = (),
) -> MujocoSimulator:
    """Make the simulated robot with all effects of its hardware that its file tells.

    Args:
        load: Of which the controller knows nothing, on the base body [kg]; what is
            taken off is negative.
    """
    hardware = () if robot.description.hardware is None else HARDWARE
    simulator = MujocoSimulator(robot, model_error, hardware, disturbances=disturbances)
    if load:
        simulator.model.body_mass[simulator.state_map.base_body] += load
        mujoco.mj_setConst(simulator.model, mujoco.MjData(simulator.model))
    return simulator


class ChangingRobot(Plant):
    """One robot up to some repetition, another one from then on, and nobody says so."""

    def __init__(
        self, before: MujocoSimulator, after: MujocoSimulator, at: int, back: float = math.inf
    ) -> None:
        """Begin as the one before.

        Args:
            at: Number of the first repetition of the other one.
            back: Number of the first repetition of the one before again; never by default.
        """
        self._before, self._after, self._others = before, after, (at, back)
        self._now, self._started = before, 0
        self.robot, self.period = before.robot, before.period
        self.velocity_time = before.velocity_time

    def start(self, posture: State, seed: int = 0) -> None:
        """Stand near a posture, changed if it is time."""
        first, back = self._others
        self._now = self._after if first <= self._started < back else self._before
        self._started += 1
        self._now.start(posture, seed)

    def measure(self) -> State:
        """Read the sensors."""
        return self._now.measure()

    def apply(self, tau: Vector) -> None:
        """Go on by one control period."""
        self._now.apply(tau)

    def truth(self) -> Truth | None:
        """Tell the state of the simulation."""
        return self._now.truth()

    def settings(self) -> dict[str, Any]:
        """Describe the robot of before: that it changed is to be found out."""
        return self._before.settings()
