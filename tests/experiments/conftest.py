from __future__ import annotations

import json
from collections.abc import Callable

import pytest

from tsd_casadi import Controller, Robot
from tsd_experiments.harness.experiment import Experiment
from tsd_experiments.harness.job import Result


@pytest.fixture(scope="session")
def finish_experiment(
    robot: Robot, controller: Controller
) -> Callable[[Experiment], dict[str, Result]]:
    """Does an experiment's jobs in this process, stage by stage."""

    def finish(experiment: Experiment) -> dict[str, Result]:
        done: dict[str, Result] = {}
        while jobs := [job for job in experiment.jobs(done) if job.name not in done]:
            for job in jobs:
                # as if it came from a file
                plain = json.loads(json.dumps(job.arguments))
                outcome = job.function(robot, controller, **plain)
                rows = json.loads(json.dumps(outcome.rows, allow_nan=False))
                done[job.name] = Result(rows, outcome.arrays, (0.0, 1.0))
        return done

    return finish
