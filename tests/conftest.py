from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import settings

from tsd_casadi import Controller, InverseDynamics, Robot, compile_controller, load_robot
from tsd_experiments.harness.experiment import Experiment
from tsd_experiments.harness.jobs import Result

settings.register_profile("tsd", deadline=None, derandomize=True, database=None)
settings.load_profile("tsd")

SHIPPED = "hermes_lower"


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot(SHIPPED)


@pytest.fixture(scope="session")
def problem(robot: Robot) -> InverseDynamics:
    return InverseDynamics(robot)


@pytest.fixture(scope="session")
def controller(robot: Robot) -> Controller:
    return compile_controller(robot, on_compile=lambda: None)


@pytest.fixture
def write_robot(robot: Robot, tmp_path: Path) -> Callable[..., Path]:
    folder = tmp_path / SHIPPED
    shutil.copytree(robot.path.parent, folder)

    def write(
        edit: Callable[[Any], object] = lambda document: None,
        urdf: Callable[[str], str] = lambda text: text,
    ) -> Path:
        path = folder / robot.path.name
        document = yaml.safe_load(robot.path.read_text())
        edit(document)
        path.write_text(yaml.safe_dump(document))
        urdf_path = folder / robot.urdf_path.name
        urdf_path.write_text(urdf(robot.urdf_path.read_text()))
        return path

    return write


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
