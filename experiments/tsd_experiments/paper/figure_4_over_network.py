"""The job behind gen_cog_err: both services are asked for everything, as a user would."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.repetition.learn import learn
from tsd_casadi.repetition.record import context_of
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_clients.remote.remote_learner import RemoteLearner
from tsd_experiments.harness.case import Case
from tsd_experiments.harness.outcome import Outcome

ITERATIONS = 2


def generalize_over_amplitude(
    robot: Robot,
    controller: WholeBodyController,
    case: dict[str, Any],
    known: list[float],
    asked: float,
    learner: RemoteLearner,
) -> Outcome:
    """Learn some amplitudes, ask for another, then learn that one as well.

    Args:
        case: What the squats have in common, plain data.
        known: Amplitudes to learn [m].
        asked: Amplitude to generalise to [m].

    Returns:
        Rows 'none', 'learned' and 'generalised', all at the asked amplitude.
    """
    setting = replace(Case.of(case), amplitude=asked)
    simulator = setting.simulator(robot)
    for entry in learner.database().entries:
        learner.forget(entry.entry)
    learn_here = partial(
        learn,
        simulator,
        controller,
        learner=learner,
        axes=setting.axes(robot),
        iterations=ITERATIONS,
        rule="plain",
        laps=setting.laps,
        transport="zenoh",
    )
    for amplitude in known:
        learn_here([replace(setting, amplitude=amplitude).motion])
    outcome = Outcome()
    motion = setting.motion
    generalized: Feedforward = learner.query(
        motion.name,
        robot=robot.name,
        kind="generalised",
        extrapolate=False,
        axes=setting.axes(robot),
        context=context_of(robot),
        version=motion.version,
        **motion.parameters,
    )
    run = simulator.run(
        controller,
        motion,
        axes=setting.axes(robot),
        laps=setting.laps,
        feedforward=generalized,
        transport="zenoh",
    )
    outcome.add("generalised", run)

    def keep(run: Run, _: list[str]) -> None:
        label = {0: "none", ITERATIONS: "learned"}.get(run.feedforward.iteration)
        if label is not None:
            outcome.add(label, run)

    learn_here([motion], on_run=keep)
    return outcome
