"""The job that runs a case once, with given weights."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.learning.feedforward import Kind
from tsd_casadi.repetition.compensator import Compensator
from tsd_casadi.repetition.learn import Learner
from tsd_casadi.robot.robot import Robot
from tsd_experiments.harness.case import Case
from tsd_experiments.harness.outcome import Outcome


def replay_case(
    robot: Robot,
    controller: WholeBodyController,
    case: dict[str, Any],
    *,
    weights: Sequence[float] | None = None,
    kind: Kind = "none",
    learner: Learner | None = None,
    label: str = "replay",
    compensators: Sequence[Compensator] = (),
) -> Outcome:
    """Run a case once with given weights and without learning.

    Args:
        case: Plain data of a ``Case``.
        weights: (L,) [m/s^2]; None for no feedforward.
        kind: Where the weights come from; 'constant' uses their mean only.
        learner: Given to jobs over the network, where the controller is remote too.
        label: Name of the run.

    Returns:
        One row.
    """
    setting = Case.of(case)
    feedforward = None if weights is None else setting.feedforward(robot, weights, kind)
    if feedforward is not None and kind == "constant":
        feedforward = feedforward.constant()
    run = setting.simulator(robot).run(
        controller,
        setting.motion,
        axes=setting.axes(robot),
        laps=setting.laps,
        feedforward=feedforward,
        gains=setting.gains,
        compensators=compensators,
        seed=setting.seed,
        transport="local" if learner is None else "zenoh",
    )
    outcome = Outcome()
    outcome.add(label, run)
    return outcome
