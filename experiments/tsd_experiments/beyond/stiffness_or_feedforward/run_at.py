"""Runs at any stiffness, the ground's force and the true centre of mass noted."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_clients.simulator.disturbances import Disturbance
from tsd_experiments.beyond.stiffness_or_feedforward.witness import Witness
from tsd_experiments.harness.case import Case


class Stiffness(Compensator):
    """P times a factor of any size, with the damping ratio kept."""

    def __init__(self, factor: float) -> None:
        """Choose the stiffness.

        Args:
            factor: On P of the learned task's axes.
        """
        self._factor = factor

    def start(self, setting: Setting) -> None:
        """Note the learned tasks."""
        axes = setting.axes[: setting.learned]
        self._tasks = tuple(dict.fromkeys(axis.rpartition(".")[0] for axis in axes))
        self._set = False

    def before(self, moment: Moment) -> None:
        """Set the gains at the first tick; they stay."""
        if not self._set:
            for task in self._tasks:
                moment.command[f"{task}.P"] *= self._factor
                moment.command[f"{task}.D"] *= math.sqrt(self._factor)
            self._set = True


def run_at(
    robot: Robot,
    controller: WholeBodyController,
    case: Case,
    factor: float,
    weights: list[float] | None,
    disturbances: Sequence[Disturbance],
) -> tuple[Run, Witness]:
    """Run a case once at a stiffness.

    Args:
        factor: On P.
        weights: Feedforward, (L,) [m/s^2]; None for none.

    Returns:
        The run, and what was noted of it.
    """
    witness = Witness()
    run = case.simulator(robot).run(
        controller,
        case.motion,
        axes=case.axes(robot),
        laps=case.laps,
        feedforward=None if weights is None else case.feedforward(robot, weights, "learned"),
        gains=case.gains,
        compensators=[Stiffness(factor)],
        disturbances=[*disturbances, witness],
        seed=case.seed,
    )
    return run, witness
