"""What is measured with one seed: learning under noise, without, and through a change."""

from __future__ import annotations

from typing import Any

import numpy as np

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.database.database import Database
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.encoding.scatter import power_of, scatter_of
from tsd_casadi.exceptions import SimulationError
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.learn import learn
from tsd_casadi.repetition.plant import Plant
from tsd_casadi.repetition.repeat import repeat
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import load_robot
from tsd_experiments.beyond.outside_the_lab.robots import (
    MODEL_ERROR,
    ChangingRobot,
    FreshTorqueNoise,
    make_robot,
)
from tsd_experiments.harness.learn_case import own_database

MOTION = Squat(0.03, 0.5)
NOISE = 1.0  # N m
ITERATIONS = 5
AFTER = 4  # repetitions after a change
WITH_LOAD = 2  # repetitions
# a repetition of which nothing is known but its number
FIRST_SEED = 1000


def learn_under_noise(robot: str, rule: RuleName, seed: int) -> dict[str, Any]:
    """Learn with torque noise, fresh in each repetition.

    Returns:
        RMS errors [mm]: after ``ITERATIONS``, 'floor' of a feedforward learned without
        noise in the very same noise, 'replay' of the learned term without noise; and
        'refused', how many repetitions there were and how often the robot was taken
        for another one; 'repeating', how much of the three errors is the same in each lap.
    """
    noise = FreshTorqueNoise(NOISE, seed)
    with own_database() as database:
        try:
            runs = _learn(make_robot(load_robot(robot), disturbances=[noise]), database, rule, seed)
        except SimulationError as error:
            return {"refused": str(error)}
        alarms = _epoch(database)
    with own_database() as database:
        quiet = _learn(make_robot(load_robot(robot)), database, rule, seed)[-1].feedforward
    noise.runs -= 1
    last = FIRST_SEED * (seed + 1) + ITERATIONS
    floor = _repeat(
        make_robot(load_robot(robot), disturbances=[noise]), quiet, last, runs[-1].laps_run
    )
    replay = _repeat(make_robot(load_robot(robot)), runs[-1].feedforward, last)
    return {
        "refused": None,
        "after": _error(runs[-1]),
        "floor": _error(floor),
        "replay": _error(replay),
        "repeating": {
            "after": repeating_error(runs[-1]),
            "floor": repeating_error(floor),
            "replay": repeating_error(replay),
        },
        "laps": [run.laps_run for run in runs],
        "errors": [_error(run) for run in runs],
        "repetitions": len(runs),
        "alarms": alarms,
    }


def learn_quietly(robot: str, rule: RuleName, seed: int, iterations: int) -> dict[str, Any]:
    """Learn without extra noise.

    Returns:
        'errors', RMS of each repetition [mm], and how often it was taken for another robot.
    """
    with own_database() as database:
        runs = _learn(make_robot(load_robot(robot)), database, rule, seed, iterations)
        alarms = _epoch(database)
    errors = [_error(run) for run in runs]
    return {"errors": errors, "repetitions": len(runs), "alarms": alarms}


def learn_through_change(
    robot: str,
    rule: RuleName,
    seed: int,
    at: int,
    model_error: float,
    load: float,
    noise: float = 0.0,
) -> dict[str, Any]:
    """Learn on a robot that is another one from some repetition on.

    Args:
        at: Number of the first repetition of the other one.
        model_error: Of the robot afterwards.
        load: On the robot afterwards [kg].
        noise: Of the joint torques [N m].

    Returns:
        'errors' RMS from that repetition on [mm], and whether it was noticed 'at_once'.
    """
    disturbances = [FreshTorqueNoise(noise, seed)] if noise else []
    plant = ChangingRobot(
        make_robot(load_robot(robot), disturbances=disturbances),
        make_robot(load_robot(robot), model_error, load, disturbances),
        at,
    )
    notes: list[list[str]] = []
    after = AFTER if not noise else 0
    with own_database() as database:
        runs = _learn(plant, database, rule, seed, at + after, notes)
    return {
        "errors": [_error(run) for run in runs[at:]],
        "at_once": _tells_change(notes[at]),
        "repetitions": at,
        "alarms": sum(_tells_change(told) for told in notes[:at]),
    }


def learn_until_return(
    robot: str, rule: RuleName, seed: int, at: int, load: float
) -> dict[str, Any]:
    """Learn on a robot that is loaded from some repetition on, and unloaded two later.

    Args:
        at: Number of the first repetition with the load.
        load: On the robot then [kg].

    Returns:
        'before', the least RMS error until then [mm], 'errors' from the day that the load
        is gone again, and whether what was learned before was taken 'again' at once.
    """
    back = at + WITH_LOAD
    plant = ChangingRobot(
        make_robot(load_robot(robot)), make_robot(load_robot(robot), MODEL_ERROR, load), at, back
    )
    notes: list[list[str]] = []
    with own_database() as database:
        runs = _learn(plant, database, rule, seed, back + 1, notes)
    errors = [_error(run) for run in runs]
    return {
        "before": min(errors[:at]),
        "errors": errors[back:],
        "again": any("is taken again" in note for note in notes[back]),
    }


def repeating_error(run: Run) -> float:
    """Compute how much of a run's RMS error along its first axis all laps have in common [mm].

    The mean of M laps holds an M-th of the power of what does not repeat: that is taken off.
    """
    basis = PeriodicBasis()
    fitted = [basis.fit(lap.phase, lap.error[:1]) for lap in run.laps if lap.error is not None]
    power = power_of(np.mean(fitted, axis=0), basis)
    repeating = float(power[0] - scatter_of(fitted, basis).of_mean[0] ** 2)
    return float(1e3 * np.sqrt(max(repeating, 0.0)))


def _learn(
    plant: Plant,
    database: Database,
    rule: RuleName,
    seed: int,
    iterations: int = ITERATIONS,
    notes: list[list[str]] | None = None,
) -> list[Run]:
    first = FIRST_SEED * (seed + 1)
    return learn(
        plant,
        compile_controller(plant.robot),
        [MOTION],
        database,
        axes=MOTION.axes(plant.robot),
        iterations=iterations,
        rule=rule,
        seed=range(first, first + iterations + 1),
        on_run=None if notes is None else lambda _, told: notes.append(told),
    )


def _repeat(plant: Plant, feedforward: Feedforward, seed: int, laps: int = 3) -> Run:
    return repeat(
        plant,
        compile_controller(plant.robot),
        MOTION,
        axes=MOTION.axes(plant.robot),
        laps=laps,
        feedforward=feedforward,
        seed=seed,
    )


def _error(run: Run) -> float:
    return 1e3 * run.errors[run.axes[0]].rms


def _epoch(database: Database) -> int:
    return database.entries()[0].epoch


def _tells_change(notes: list[str]) -> bool:
    return any("not the robot of before" in note for note in notes)
