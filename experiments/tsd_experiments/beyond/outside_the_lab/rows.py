"""What is measured with one seed: learning under noise, without, and through a change."""

from __future__ import annotations

from typing import Any

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.database.database import Database
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
    ChangingRobot,
    FreshTorqueNoise,
    make_robot,
)
from tsd_experiments.harness.learn_case import own_database

ROBOT = "hermes_lower"
MOTION = Squat(0.03, 0.5)
NOISE = 1.0  # N m
ITERATIONS = 5
AFTER = 4  # repetitions after a change
# a repetition of which nothing is known but its number
FIRST_SEED = 1000


def learn_under_noise(rule: RuleName, seed: int) -> dict[str, Any]:
    """Learn with torque noise, fresh in each repetition.

    Returns:
        RMS errors [mm]: after ``ITERATIONS``, 'floor' of a feedforward learned without
        noise in the very same noise, 'replay' of the learned term without noise; and
        'refused', how many repetitions there were and how often the robot was taken
        for another one.
    """
    noise = FreshTorqueNoise(NOISE, seed)
    with own_database() as database:
        try:
            runs = _learn(make_robot(_robot(), disturbances=[noise]), database, rule, seed)
        except SimulationError as error:
            return {"refused": str(error)}
        alarms = _epoch(database)
    with own_database() as database:
        quiet = _learn(make_robot(_robot()), database, rule, seed)[-1].feedforward
    noise.runs -= 1
    last = FIRST_SEED * (seed + 1) + ITERATIONS
    floor = _repeat(make_robot(_robot(), disturbances=[noise]), quiet, last, runs[-1].laps_run)
    replay = _repeat(make_robot(_robot()), runs[-1].feedforward, last)
    return {
        "refused": None,
        "after": _error(runs[-1]),
        "floor": _error(floor),
        "replay": _error(replay),
        "laps": [run.laps_run for run in runs],
        "errors": [_error(run) for run in runs],
        "repetitions": len(runs),
        "alarms": alarms,
    }


def learn_quietly(rule: RuleName, seed: int, iterations: int) -> dict[str, Any]:
    """Learn without extra noise.

    Returns:
        'errors', RMS of each repetition [mm], and how often it was taken for another robot.
    """
    with own_database() as database:
        runs = _learn(make_robot(_robot()), database, rule, seed, iterations)
        alarms = _epoch(database)
    errors = [_error(run) for run in runs]
    return {"errors": errors, "repetitions": len(runs), "alarms": alarms}


def learn_through_change(
    rule: RuleName, seed: int, at: int, model_error: float, load: float, noise: float = 0.0
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
        make_robot(_robot(), disturbances=disturbances),
        make_robot(_robot(), model_error, load, disturbances),
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
        compile_controller(_robot()),
        [MOTION],
        database,
        axes=MOTION.axes(_robot()),
        iterations=iterations,
        rule=rule,
        seed=range(first, first + iterations + 1),
        on_run=None if notes is None else lambda _, told: notes.append(told),
    )


def _repeat(plant: Plant, feedforward: Feedforward, seed: int, laps: int = 3) -> Run:
    return repeat(
        plant,
        compile_controller(_robot()),
        MOTION,
        axes=MOTION.axes(_robot()),
        laps=laps,
        feedforward=feedforward,
        seed=seed,
    )


def _robot() -> Any:
    return load_robot(ROBOT)


def _error(run: Run) -> float:
    return 1e3 * run.errors[run.axes[0]].rms


def _epoch(database: Database) -> int:
    return database.entries()[0].epoch


def _tells_change(notes: list[str]) -> bool:
    return any("not the robot of before" in note for note in notes)
