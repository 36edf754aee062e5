"""What methods learned in some motions, generalised to one that was never tried."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from tsd_casadi.generalization.weight_regression import WeightRegression
from tsd_casadi.motions.motion import Motion
from tsd_experiments.comparison.baselines.generalize_torques import generalize_torques, varied
from tsd_experiments.comparison.baselines.torque_feedforward import LearnedTorque
from tsd_experiments.comparison.bench import Alternative, Bench
from tsd_experiments.comparison.learn_plainly import learn_task, learn_torque


def generalized_acceleration(benches: Sequence[Bench], asked: Motion) -> Alternative:
    """Generalise task accelerations to a motion that was never tried."""
    learned = [learn_task(bench) for bench in benches]
    names, inputs = varied([item.parameters for item in learned])
    weights = [item.weights for item in learned]
    regression = WeightRegression(asked.declaration(), names, inputs, weights, learned[0].basis)
    mean, deviations = regression.predict(asked.parameters)
    feedforward = replace(
        learned[0],
        weights=mean,
        standard_deviations=deviations,
        kind="generalised",
        parameters=asked.parameters,
    )
    return Alternative(
        benches[0].controller,
        feedforward,
        numbers_learned=sum(item.weights.size for item in learned),
        repetitions=sum(bench.iterations for bench in benches),
    )


def generalized_torque(benches: Sequence[Bench], asked: Motion) -> Alternative:
    """Generalise joint torques to a motion that was never tried."""
    learned = [learn_torque(bench) for bench in benches]
    torques = generalize_torques(asked.declaration(), learned, asked.parameters)
    return Alternative(
        benches[0].controller,
        compensators=[LearnedTorque(torques)],
        numbers_learned=sum(item.weights.size for item in learned),
        repetitions=sum(bench.iterations for bench in benches),
    )


GENERALIZED: dict[str, Callable[[Sequence[Bench], Motion], Alternative]] = {
    "task acceleration": generalized_acceleration,
    "joint torque": generalized_torque,
}
