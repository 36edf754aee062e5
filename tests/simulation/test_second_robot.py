from __future__ import annotations

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

import tsd_models
from tsd_casadi import Controller, Robot, Squat, State, Status, compile_controller
from tsd_clients import MujocoSimulator
from tsd_clients.simulator.parity import measure_parity

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def its_controller(mini_biped: Robot) -> Controller:
    return compile_controller(mini_biped, on_compile=lambda: None)


def test_it_is_another_kind_of_robot(mini_biped: Robot, robot: Robot) -> None:
    assert mini_biped.n == 12
    assert not set(mini_biped.joint_names) & set(robot.joint_names)
    kinds = {joint.shortname() for joint in mini_biped.model.joints}
    assert {"JointModelRevoluteUnaligned", "JointModelPrismaticUnaligned"} <= kinds
    names = [
        part.name for part in (*mini_biped.description.contacts, *mini_biped.description.tasks)
    ]
    others = [part.name for part in (*robot.description.contacts, *robot.description.tasks)]
    assert not set(names) & set(others)


def test_urdf_and_scene_are_the_same_body(mini_biped: Robot) -> None:
    model = mujoco.MjModel.from_xml_path(str(mini_biped.scene_path))
    in_scene = [model.joint(index).name for index in range(1, model.njnt)]
    assert in_scene != mini_biped.joint_names
    assert sorted(in_scene) == sorted(mini_biped.joint_names)
    parity = measure_parity(mini_biped, model, states=20)
    assert max(vars(parity).values()) < 1e-9


def test_it_stands_at_home(mini_biped: Robot, its_controller: Controller) -> None:
    tick = its_controller.tick(mini_biped.home, its_controller.command())
    assert tick.status == Status.OK
    assert list(tick.wrenches) == ["near_ground", "far_ground"]
    pushes = [wrench[2] for wrench in tick.wrenches.values()]
    assert min(pushes) > 0.4 * mini_biped.weight
    assert sum(pushes) == pytest.approx(mini_biped.weight, rel=1e-6)
    assert np.abs(tick.qdd).max() < 1e-3


def test_it_stands_on_either_foot(mini_biped: Robot, its_controller: Controller) -> None:
    for lifted, standing in (("near_ground", "far_ground"), ("far_ground", "near_ground")):
        command = its_controller.command()
        command[f"{lifted}.active"] = 0.0
        tick = its_controller.tick(mini_biped.home, command)
        assert tick.status == Status.OK
        assert np.abs(tick.wrenches[lifted]).max() < 1e-9
        assert tick.wrenches[standing][2] > 0.5 * mini_biped.weight


@pytest.mark.parametrize("extension", [1e7, 1e8, 1e9])
def test_legs_of_absurd_length_are_answered_safely(
    extension: float, mini_biped: Robot, its_controller: Controller
) -> None:
    q = mini_biped.home.q.copy()
    for joint in ("near_slide", "far_slide"):
        q[7 + mini_biped.joint_names.index(joint)] = extension
    tick = its_controller.tick(State(q, mini_biped.home.v), its_controller.command())
    assert tick.status in (Status.SINGULAR, Status.NOT_FINITE)
    assert np.isfinite(tick.reply).all()
    assert (np.abs(tick.tau) <= mini_biped.torque_limit).all()


def test_it_squats(mini_biped: Robot, its_controller: Controller) -> None:
    run = MujocoSimulator(mini_biped).run(its_controller, Squat(0.03, 1.0), laps=2)
    assert not run.fell
    assert run.failures == {}
    assert run.steady
    assert run.laps_run <= 6
    assert run.errors["mass.z"].peak < 1e-3
    heights = run.along("reference", "mass.z")[run.log["measured"]]
    assert np.ptp(heights) == pytest.approx(0.06, rel=1e-2)


# the robot that a command takes if none is named
DEFAULTS = {
    # help that shows what can be typed
    "cli/tsd_cli/commands/robot.py": r"^      tsd robot new --package g1 .*$",
    "cli/tsd_cli/options/proposal.py": r'^ +help="Robot of the package example-robot-data, .*$',
    "cli/tsd_cli/options/robot.py": r'^    \] = "hermes_lower"$',
    "server/tsd_server/__main__.py": r'^ +default="hermes_lower",$',
    "experiments/tsd_experiments/beyond/any_motion/__main__.py": (
        r'^    parser.add_argument\("--robot", default="hermes_lower", metavar="NAME\|FILE"\)$'
    ),
    "experiments/tsd_experiments/beyond/outside_the_lab/__main__.py": (
        r'^    parser.add_argument\("--robot", default="hermes_lower", metavar="NAME\|FILE"\)$'
    ),
    # whose data are of this robot
    "experiments/tsd_experiments/beyond/trusted_regression/learned_terms.py": (
        r'^    robot = load_robot\("hermes_lower"\)$'
    ),
}


# an experiment about these robots
ABOUT_ROBOTS = "experiments/tsd_experiments/beyond/humanoids/"


def sources() -> list[Path]:
    folders = ("tsd_casadi", "server", "clients", "binding", "cli", "experiments")
    return [
        path
        for folder in folders
        for ending in ("*.py", "*.pyi", "*.c", "*.h", "*.cpp", "*.hpp")
        for path in (ROOT / folder).rglob(ending)
        if not str(path.relative_to(ROOT)).startswith(ABOUT_ROBOTS)
    ]


def test_no_source_knows_a_robot_by_name() -> None:
    names = list(tsd_models.robot_files())
    assert names
    named = re.compile(rf"\b({'|'.join(names)})\b")
    found = []
    for path in sources():
        default = DEFAULTS.get(str(path.relative_to(ROOT)), "^$")
        for number, line in enumerate(path.read_text().splitlines(), start=1):
            if named.search(line) and not re.match(default, line):
                found.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()}")
    assert found == []


def test_the_search_sees_every_package() -> None:
    assert {"robot.py", "tick.c", "symbolic_model.cpp", "service.py", "simulator.py"} <= {
        path.name for path in sources()
    }
