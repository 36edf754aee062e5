"""What every layer of the tests shares: markers by folder, hypothesis profiles, robots."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

# before NumPy is loaded, and for the processes that tests start: several workers
# with a thread per core each would wait for one another most of the time
os.environ.setdefault("OMP_NUM_THREADS", "1")

# behind what is installed: the benchmarks, whose short forms are tests
sys.path.append(str(Path(__file__).parents[1]))

import pytest
import yaml
from hypothesis import settings

import tsd_models
from tsd_casadi import Controller, InverseDynamics, Robot, compile_controller, load_robot

TESTS = Path(__file__).parent
LAYERS = ("unit", "simulation", "services", "experiments", "acceptance")
SHIPPED = "hermes_lower"
MINI_BIPED = TESTS / "robots" / "mini_biped" / "mini_biped.yaml"
MINI_QUADRUPED = TESTS / "robots" / "mini_quadruped" / "mini_quadruped.yaml"
PEG_LEG = TESTS / "robots" / "mini_biped" / "peg_leg.yaml"
ROBOTS = {
    **tsd_models.robot_files(),
    "mini_biped": MINI_BIPED,
    "mini_quadruped": MINI_QUADRUPED,
    "peg_leg": PEG_LEG,
}

# the same examples at every run
settings.register_profile(
    "quick", max_examples=100, deadline=None, derandomize=True, database=None, print_blob=True
)
# where the same tests run once more, with another Python or other versions of libraries
settings.register_profile("few", settings.get_profile("quick"), max_examples=20)
# others at every run, and many of them
settings.register_profile(
    "thorough", settings.get_profile("quick"), max_examples=2000, derandomize=False
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "quick"))


@pytest.fixture(scope="session", autouse=True)
def run_directory(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Services of the tests are not those of whoever runs them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TSD_RUN_DIR", str(tmp_path_factory.mktemp("run") / "tsd"))
        yield


# before markers are selected
@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        layer = item.path.relative_to(TESTS).parts[0]
        if layer not in LAYERS:
            raise pytest.UsageError(f"{item.path} is in none of the layers {', '.join(LAYERS)}")
        item.add_marker(layer)
        if item.get_closest_marker("long") and not item.get_closest_marker("timeout"):
            item.add_marker(pytest.mark.timeout(1800))


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot(SHIPPED)


@pytest.fixture(scope="session")
def mini_biped() -> Robot:
    """A user's robot: smaller, of other joints and names, in no package."""
    return load_robot(MINI_BIPED)


@pytest.fixture(scope="session")
def mini_quadruped() -> Robot:
    """A robot on four balls, each of which touches the ground in a point."""
    return load_robot(MINI_QUADRUPED)


@pytest.fixture(scope="session")
def peg_leg() -> Robot:
    """A biped that stands on a point and a sole, in this order."""
    return load_robot(PEG_LEG)


@pytest.fixture(scope="session", params=ROBOTS)
def any_robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(ROBOTS[request.param])


@pytest.fixture(scope="session")
def problem(robot: Robot) -> InverseDynamics:
    return InverseDynamics(robot)


@pytest.fixture(scope="session")
def controller(robot: Robot) -> Controller:
    return compile_controller(robot, on_compile=lambda: None)


@pytest.fixture(scope="session")
def any_controller(any_robot: Robot) -> Controller:
    return compile_controller(any_robot, on_compile=lambda: None)


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
        source_path = folder / robot.source_path.name
        source_path.write_text(urdf(robot.source_path.read_text()))
        return path

    return write
