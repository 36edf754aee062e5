"""The paper's plain sum, in task accelerations and in joint torques."""

from __future__ import annotations

import numpy as np

from tsd_casadi.encoding.laps import fit_laps
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.iterative_learning import update_weights
from tsd_casadi.repetition.record import record_of
from tsd_experiments.comparison.baselines.joint_torque_learning import learn_joint_torques
from tsd_experiments.comparison.baselines.torque_feedforward import TorqueFeedforward
from tsd_experiments.comparison.bench import Bench


def learn_task(bench: Bench) -> Feedforward:
    """Learn task accelerations by the paper's plain sum.

    Returns:
        The feedforward after the last iteration, not yet tried.

    Raises:
        SimulationError: If a repetition fell or never settled.
        InvalidValue: If iterations is not at least 1.
    """
    feedforward = None
    for iteration in range(1, bench.iterations + 1):
        run = bench.simulator.run(
            bench.controller,
            bench.motion,
            axes=bench.axes,
            feedforward=feedforward,
            gains=bench.gains,
            seed=bench.seed,
        )
        recording = record_of(run, bench.robot)
        fitted = fit_laps(recording.laps, recording.basis)
        weights = update_weights(recording.applied, fitted.feedback)
        feedforward = Feedforward(
            axes=run.feedforward.axes,
            basis=recording.basis,
            weights=weights,
            standard_deviations=np.zeros_like(weights),
            kind="learned",
            parameters=bench.motion.parameters,
            provenance={"iteration": iteration},
        )
    if feedforward is None:
        raise InvalidValue("iterations", bench.iterations, "at least 1")
    return feedforward


def learn_torque(bench: Bench) -> TorqueFeedforward:
    """Learn joint torques by the same plain sum.

    Returns:
        The feedforward after the last iteration, not yet tried.

    Raises:
        SimulationError: If a repetition fell or never settled.
        InvalidValue: If iterations is not at least 1.
    """
    _, learned = learn_joint_torques(
        bench.simulator,
        bench.controller,
        bench.motion,
        bench.iterations,
        gains=bench.gains,
        seed=bench.seed,
    )
    return learned
