"""Methods that one would try against a wrong model, each prepared in the same way.

What learns, does so from a number of repetitions of one squat; what is
identified, from a single one.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from pathlib import Path

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.database.database import Database
from tsd_casadi.identification.identified_robot import write_robot
from tsd_casadi.identification.inertias import Identified, identify_inertias, identify_with_friction
from tsd_casadi.identification.observations import Observations
from tsd_casadi.identification.physical_consistency import PARAMETERS
from tsd_casadi.repetition.compensator import Compensator
from tsd_casadi.repetition.learn import learn
from tsd_experiments.comparison.baselines.disturbance_observer import (
    DisturbanceObserver,
    usual_bandwidth,
)
from tsd_experiments.comparison.baselines.excitation import Excitation
from tsd_experiments.comparison.baselines.friction_feedforward import FrictionFeedforward
from tsd_experiments.comparison.baselines.integral_action import IntegralAction
from tsd_experiments.comparison.baselines.motion_recorder import MotionRecorder, observe
from tsd_experiments.comparison.baselines.torque_feedforward import LearnedTorque
from tsd_experiments.comparison.bench import Alternative, Bench
from tsd_experiments.comparison.learn_plainly import learn_task, learn_torque


def nothing(bench: Bench) -> Alternative:
    """Prepare feedback alone."""
    return Alternative(bench.controller)


def integral(bench: Bench) -> Alternative:
    """Prepare integral action with its usual gain."""
    return Alternative(bench.controller, compensators=[IntegralAction()])


def stiff_integral(bench: Bench) -> Alternative:
    """Prepare integral action at half of the Routh limit."""
    Ki = math.prod(_gains(bench)) / 2
    return Alternative(bench.controller, compensators=[IntegralAction(Ki)])


def observer(bench: Bench) -> Alternative:
    """Prepare a disturbance observer with its usual bandwidth."""
    return Alternative(bench.controller, compensators=[DisturbanceObserver()])


def fast_observer(bench: Bench) -> Alternative:
    """Prepare a disturbance observer as fast as the lags allow with some margin."""
    _, D = _gains(bench)
    bandwidth = usual_bandwidth(bench.robot, D, crossover=1.0)
    return Alternative(bench.controller, compensators=[DisturbanceObserver(bandwidth)])


def constant(bench: Bench) -> Alternative:
    """Prepare only the mean of learned task accelerations."""
    learned = learn_task(bench)
    return Alternative(
        bench.controller, learned.constant(), numbers_learned=1, repetitions=bench.iterations
    )


def task_acceleration(bench: Bench) -> Alternative:
    """Prepare task accelerations, learned by the paper's rule."""
    learned = learn_task(bench)
    return Alternative(
        bench.controller,
        learned,
        numbers_learned=learned.weights.size,
        repetitions=bench.iterations,
    )


def stable_task_acceleration(bench: Bench) -> Alternative:
    """Prepare task accelerations, learned by the stable rule."""
    with tempfile.TemporaryDirectory() as folder, Database(Path(folder) / "learned") as database:
        learn(
            bench.simulator,
            bench.controller,
            [bench.motion],
            database,
            axes=bench.axes,
            iterations=bench.iterations,
            rule="stable",
            gains=bench.gains,
            seed=bench.seed,
        )
        learned = database.entries()[0].feedforward()
    return Alternative(
        bench.controller,
        learned,
        numbers_learned=learned.weights.size,
        repetitions=bench.iterations,
    )


def joint_torque(bench: Bench) -> Alternative:
    """Prepare joint torques, learned by the plain sum."""
    learned = learn_torque(bench)
    return Alternative(
        bench.controller,
        compensators=[LearnedTorque(learned)],
        numbers_learned=learned.weights.size,
        repetitions=bench.iterations,
    )


def identified(bench: Bench) -> Alternative:
    """Prepare a controller compiled from inertias identified in one repetition."""
    return _recompiled(bench, identify_inertias(bench.robot, _observed(bench)))


def identified_with_friction(bench: Bench) -> Alternative:
    """Prepare an identified controller with joint friction, compensated by feedforward."""
    found = identify_with_friction(bench.robot, _observed(bench))
    return _recompiled(bench, found, FrictionFeedforward(found.friction))


def identified_with_excitation(bench: Bench) -> Alternative:
    """Prepare an identified controller with friction, from a repetition that sways on purpose."""
    observed = _observed(bench, Excitation())
    found = identify_with_friction(bench.robot, observed)
    return _recompiled(bench, found, FrictionFeedforward(found.friction))


METHODS: dict[str, Callable[[Bench], Alternative]] = {
    "none": nothing,
    "integral": integral,
    "integral, Routh / 2": stiff_integral,
    "observer": observer,
    "observer, fast": fast_observer,
    "constant": constant,
    "task acceleration": task_acceleration,
    "task acceleration, stable": stable_task_acceleration,
    "joint torque": joint_torque,
    "identified": identified,
    "identified, friction": identified_with_friction,
    "identified, friction, excited": identified_with_excitation,
}


def _gains(bench: Bench) -> tuple[float, float]:
    """Compute P and D of the axis that is moved."""
    task, _, axis = bench.axes[0].rpartition(".")
    component = bench.controller.format.component_index(task, axis)
    command, factors = bench.controller.command(), bench.gains
    P, D = (float(command[f"{task}.{gain}"][component]) for gain in "PD")
    return P * factors.P, D * factors.D


def _observed(bench: Bench, *others: Compensator) -> Observations:
    recorder = MotionRecorder()
    run = bench.simulator.run(
        bench.controller,
        bench.motion,
        axes=bench.axes,
        gains=bench.gains,
        compensators=[*others, recorder],
        seed=bench.seed,
    )
    return observe(run, recorder)


def _recompiled(bench: Bench, found: Identified, *compensators: Compensator) -> Alternative:
    with tempfile.TemporaryDirectory() as folder:
        robot = write_robot(bench.robot, found.inertias, Path(folder))
        controller = compile_controller(robot, on_compile=lambda: None)
    friction = 2 * bench.robot.n if compensators else 0
    return Alternative(
        controller,
        compensators=compensators,
        numbers_learned=PARAMETERS * len(found.inertias) + friction,
        repetitions=1,
    )
