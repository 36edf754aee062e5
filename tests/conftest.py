from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import settings

from tsd_casadi import Controller, InverseDynamics, Robot, compile_controller, load_robot

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
