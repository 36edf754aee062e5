"""Methods made ready for a scenario, each independent of all others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.squat import Squat
from tsd_casadi.robot.robot import Robot
from tsd_clients.simulator.simulator import MujocoSimulator
from tsd_experiments.comparison.bench import Alternative, Bench
from tsd_experiments.comparison.generalized_methods import GENERALIZED
from tsd_experiments.comparison.methods import METHODS
from tsd_experiments.comparison.scenario import Scenario

ITERATIONS = 5
AMPLITUDES = (0.02, 0.04, 0.06, 0.08)  # m, what that is generalised from


def prepare(
    robot: Robot,
    controller: WholeBodyController,
    method: str,
    scenario: Scenario,
    *,
    iterations: int = ITERATIONS,
) -> tuple[Alternative, Bench]:
    """Make one method ready for one scenario, independent of all others.

    Args:
        method: One of ``METHODS``.
        iterations: How many repetitions may be learned from.

    Returns:
        The method, and where it was prepared.

    Raises:
        InvalidValue: If there is no such method.
        SimulationError: If nothing could be learned.
    """
    if method not in METHODS:
        raise InvalidValue("method", f"'{method}'", f"one of {', '.join(METHODS)}")
    bench = _bench_for(robot, controller, scenario, scenario.squat, iterations)
    return METHODS[method](bench), bench


def prepare_generalized(
    robot: Robot,
    controller: WholeBodyController,
    method: str,
    scenario: Scenario,
    *,
    amplitudes: Sequence[float] = AMPLITUDES,
    iterations: int = ITERATIONS,
) -> tuple[Alternative, Bench]:
    """Learn a method at some amplitudes and generalise it to the scenario's other one.

    Args:
        method: One of ``GENERALIZED``.
        scenario: Its squat's amplitude is not used.
        amplitudes: What is learned [m].
        iterations: Repetitions of each.

    Returns:
        The method, and where it was learned first.

    Raises:
        InvalidValue: If there is no such method.
        SimulationError: If nothing could be learned.
    """
    if method not in GENERALIZED:
        raise InvalidValue("method", f"'{method}'", f"one of {', '.join(GENERALIZED)}")
    squats = [replace(scenario.squat, amplitude=amplitude) for amplitude in amplitudes]
    benches = [_bench_for(robot, controller, scenario, squat, iterations) for squat in squats]
    return GENERALIZED[method](benches, scenario.transfers["amplitude"]), benches[0]


def _bench_for(
    robot: Robot,
    controller: WholeBodyController,
    scenario: Scenario,
    squat: Squat,
    iterations: int,
) -> Bench:
    simulator = MujocoSimulator(robot, scenario.model_error, scenario.hardware)
    return Bench(robot, controller, simulator, squat, iterations, scenario.gains, scenario.seed)
