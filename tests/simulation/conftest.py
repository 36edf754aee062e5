from __future__ import annotations

import pytest

from tsd_casadi import Robot
from tsd_clients import MujocoSimulator


@pytest.fixture(scope="session")
def simulator(robot: Robot) -> MujocoSimulator:
    """The controller believes every link to be a tenth too heavy."""
    return MujocoSimulator(robot, model_error=0.1)
