"""What one would try instead of learning task accelerations, in the same runs.

Every method is prepared at one squat, then measured there and, reused as it is,
at another amplitude, frequency and posture. All follow the same reference in
the world; the true error is that of the simulated robot's centre of mass.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.gains import UNCHANGED, Gains
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_clients.simulator.disturbances import Disturbance
from tsd_clients.simulator.model_error import ModelError
from tsd_clients.simulator.simulator import MujocoSimulator
from tsd_experiments.comparison.alternative_methods import METHODS
from tsd_experiments.comparison.bench import Alternative, Bench
from tsd_experiments.comparison.generalized_methods import GENERALISED

ITERATIONS = 5
TEN_PERCENT = ModelError(0.1)
LARGER = 0.05  # m, the other amplitude
AMPLITUDES = (0.02, 0.04, 0.06, 0.08)  # m, what that is generalised from
TALL = 0.055  # m, the other posture's height above home


@dataclass(frozen=True)
class Scenario:
    """One simulated robot and the squat that is learned on it.

    Attributes:
        name: For the rows.
        squat: What is learned.
        other_frequency: What it is transferred to [Hz].
        hardware: Effects that count.
        model_error: Of the links.
        gains: Factors on the task's gains.
        seed: Of the starting randomness and the sensors' noise.
    """

    name: str
    squat: Squat
    other_frequency: float
    hardware: tuple[str, ...] = ()
    model_error: ModelError = TEN_PERCENT
    gains: Gains = UNCHANGED
    seed: int = 0

    @property
    def transfers(self) -> dict[str, Squat]:
        """The squat learned and the others, by what is changed."""
        A, f, h = self.squat.amplitude, self.squat.frequency, self.squat.height
        return {
            "none": self.squat,
            "amplitude": Squat(LARGER, f, h),
            "frequency": Squat(A, self.other_frequency, h),
            "posture": Squat(A, f, TALL),
        }


SCENARIOS = {
    "stand-in": Scenario("stand-in", Squat(0.03, 0.5), 0.25, hardware=("all",)),
    "ideal": Scenario("ideal", Squat(0.03, 0.25), 0.5),
}


def prepare(
    robot: Robot,
    controller: WholeBodyController,
    method: str,
    scenario: Scenario,
    *,
    iterations: int = ITERATIONS,
) -> tuple[Alternative, Bench]:
    """One method ready for one scenario, independent of all others.

    Args:
        robot: With its nominal model.
        controller: Of that model.
        method: One of ``METHODS``.
        scenario: Simulated robot and squat.
        iterations: How many repetitions may be learned from.

    Returns:
        The method, and where it was prepared.

    Raises:
        InvalidValue: If there is no such method.
        SimulationError: If nothing could be learned.
    """
    if method not in METHODS:
        raise InvalidValue("method", f"'{method}'", f"one of {', '.join(METHODS)}")
    bench = bench_for(robot, controller, scenario, scenario.squat, iterations)
    return METHODS[method](bench), bench


def compare_generalised(
    robot: Robot,
    controller: WholeBodyController,
    method: str,
    scenario: Scenario,
    *,
    amplitudes: Sequence[float] = AMPLITUDES,
    iterations: int = ITERATIONS,
) -> dict[str, Any]:
    """What is learned at some amplitudes, generalised to one between.

    Args:
        robot: With its nominal model.
        controller: Of that model.
        method: One of ``GENERALISED``.
        scenario: Simulated robot and squat, but for the amplitude.
        amplitudes: What is learned [m].
        iterations: Repetitions of each.

    Returns:
        Plain data, a row as of ``measure``.

    Raises:
        InvalidValue: If there is no such method.
        SimulationError: If nothing could be learned.
    """
    if method not in GENERALISED:
        raise InvalidValue("method", f"'{method}'", f"one of {', '.join(GENERALISED)}")
    squats = [replace(scenario.squat, amplitude=amplitude) for amplitude in amplitudes]
    benches = [bench_for(robot, controller, scenario, squat, iterations) for squat in squats]
    asked = scenario.transfers["amplitude"]
    alternative = GENERALISED[method](benches, asked)
    measured = measure(alternative, benches[0], scenario, asked)
    return {"method": method, **measured}


def bench_for(
    robot: Robot,
    controller: WholeBodyController,
    scenario: Scenario,
    squat: Squat,
    iterations: int,
) -> Bench:
    """Where methods are prepared.

    Args:
        robot: With its nominal model.
        controller: Of that model.
        scenario: Simulated robot.
        squat: What is learned.
        iterations: How many repetitions may be learned from.
    """
    simulator = MujocoSimulator(robot, scenario.model_error, scenario.hardware)
    return Bench(robot, controller, simulator, squat, iterations, scenario.gains, scenario.seed)


def drive(
    alternative: Alternative,
    bench: Bench,
    scenario: Scenario,
    squat: Squat,
    disturbances: Sequence[Disturbance] = (),
) -> Run:
    """One run with a method.

    Args:
        alternative: The method.
        bench: Where it was prepared.
        scenario: Simulated robot.
        squat: What to do.
        disturbances: What pushes the robot.
    """
    return bench.simulator.run(
        alternative.controller,
        squat,
        feedforward=alternative.feedforward,
        gains=scenario.gains,
        compensators=alternative.compensators,
        disturbances=disturbances,
        seed=scenario.seed,
    )


def measure(
    alternative: Alternative, bench: Bench, scenario: Scenario, squat: Squat
) -> dict[str, Any]:
    """What a method does in one run, plain data.

    Args:
        alternative: The method.
        bench: Where it was prepared.
        scenario: Simulated robot.
        squat: What to do.
    """
    return describe(drive(alternative, bench, scenario, squat), alternative, scenario)


def describe(run: Run, alternative: Alternative, scenario: Scenario) -> dict[str, Any]:
    """One run with a method, plain data.

    Args:
        run: The run.
        alternative: The method.
        scenario: Simulated robot.
    """
    return {
        "scenario": scenario.name,
        **measures(run),
        "numbers_learned": alternative.numbers_learned,
        "repetitions": alternative.repetitions,
    }


def measures(run: Run) -> dict[str, Any]:
    """What is compared of a run, plain data; None where nothing was measured."""
    log = run.log
    true_error = np.asarray(log["true_error"][log["measured"]])
    values = {
        **run.errors(),
        "true_ac_rms_error_m": float(true_error.std()) if true_error.size else math.nan,
    }
    return {
        **run.motion.parameters,
        **{name: value if math.isfinite(value) else None for name, value in values.items()},
        "laps_run": run.laps_run,
        "steady": run.steady,
        "fell": run.fell,
        "failures": run.failures,
    }
