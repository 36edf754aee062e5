"""The functions that jobs name; called in worker processes."""

from __future__ import annotations

from typing import Any

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.repetition.learn import Learner
from tsd_casadi.robot.robot import Robot
from tsd_experiments.harness.case import Case, Outcome, learn_case, replay_case


def learn(
    robot: Robot,
    controller: WholeBodyController,
    case: dict[str, Any],
    learner: Learner | None = None,
    **options: Any,
) -> Outcome:
    """See ``learn_case``.

    Args:
        robot: The robot.
        controller: Its controller, of the service if there is a learner.
        case: The case, plain data.
        learner: The learner service of a job over the network.
        options: As of ``learn_case``.
    """
    transport = "local" if learner is None else "zenoh"
    return learn_case(
        Case.of(case), robot, controller, learner=learner, transport=transport, **options
    )


def replay(
    robot: Robot,
    controller: WholeBodyController,
    case: dict[str, Any],
    weights: list[float] | None = None,
    kind: Any = "none",
    learner: Learner | None = None,
    **options: Any,
) -> Outcome:
    """See ``replay_case``.

    Args:
        robot: The robot.
        controller: Its controller, of the service if there is a learner.
        case: The case, plain data.
        weights: (L,) [m/s^2]; None for no feedforward.
        kind: Where the weights come from.
        learner: The learner service of a job over the network.
        options: As of ``replay_case``.
    """
    transport = "local" if learner is None else "zenoh"
    return replay_case(
        Case.of(case),
        robot,
        controller,
        weights=weights,
        kind=kind,
        transport=transport,
        **options,
    )
