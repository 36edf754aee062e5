"""Where a method is prepared, and what comes of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.compensator import Compensator
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.robot.robot import Robot
from tsd_clients.simulator.simulator import MujocoSimulator


@dataclass(frozen=True)
class Bench:
    """Where a method is prepared.

    Attributes:
        robot: With its nominal model.
        controller: Of that model.
        simulator: The simulated robot.
        motion: What is learned.
        iterations: How many repetitions may be learned from.
        gains: Factors on the task's gains.
        seed: Of the starting randomness and the sensors' noise.
    """

    robot: Robot
    controller: WholeBodyController
    simulator: MujocoSimulator
    motion: Motion
    iterations: int
    gains: Gains
    seed: int

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the learned axes: those that are moved."""
        return self.motion.axes(self.robot)


@dataclass(frozen=True)
class Alternative:
    """A method, ready to be measured.

    Attributes:
        controller: Nominal or identified.
        feedforward: Along the learned axes.
        compensators: What else it adds.
        numbers_learned: How many numbers it takes from data.
        repetitions: How many repetitions it took them from.
    """

    controller: WholeBodyController
    feedforward: Feedforward | None = None
    compensators: Sequence[Compensator] = ()
    numbers_learned: int = 0
    repetitions: int = 0
