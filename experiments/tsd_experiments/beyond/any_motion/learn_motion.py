"""The job that learns any motion along any axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.motions.catalogue import find_motion
from tsd_casadi.repetition.learn import learn
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_clients.simulator.simulator import MujocoSimulator
from tsd_experiments.harness.learn_case import own_database
from tsd_experiments.harness.outcome import Outcome


def learn_motion(
    robot: Robot,
    controller: WholeBodyController,
    motion: str,
    parameters: dict[str, float],
    *,
    alone: int | None = None,
    moved_only: bool = False,
    model_error: float = 0.1,
    hardware: Sequence[str] = (),
    rule: RuleName = "stable",
    iterations: int = 2,
    seed: int = 0,
) -> Outcome:
    """Learn a motion from nothing.

    Args:
        motion: Name of a shipped motion.
        alone: Learn only this one of the axes that move, counted from 0.
        moved_only: Learn only the axes that move; by default all of the centre of
            mass with them.
        iterations: N; there are N + 1 runs.

    Returns:
        Rows 'iteration 0' ..., and of the last run the measured configurations
        with the first moved axis highest and lowest, 'extremes', (2, nq).
    """
    moving = find_motion(motion)(**parameters)
    moved = moving.axes(robot)
    outcome = Outcome()

    def keep(run: Run, notes: list[str]) -> None:
        outcome.add(f"iteration {len(outcome.rows)}", run, notes=notes, robot_file=str(robot.path))
        place = run.measured("reference")[:, run.axes.index(moved[0])]
        postures = run.measured("q")[[int(np.argmax(place)), int(np.argmin(place))]]
        outcome.arrays["extremes"] = postures.astype(float)

    with own_database() as database:
        learn(
            MujocoSimulator(robot, model_error, hardware),
            controller,
            [moving],
            database,
            axes=(moved[alone],) if alone is not None else moved if moved_only else None,
            iterations=iterations,
            rule=rule,
            seed=seed,
            on_run=keep,
        )
    return outcome
