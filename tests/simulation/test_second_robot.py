from __future__ import annotations

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

import tsd_models
from tsd_casadi import Controller, Robot, Squat, State, Status, compile_controller, load_robot
from tsd_clients import MujocoSimulator
from tsd_clients.simulator.parity import measure_parity

FOLDER = Path(__file__).parents[1] / "robots" / "mini_biped"
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def biped() -> Robot:
    return load_robot(FOLDER / "mini_biped.yaml")


@pytest.fixture(scope="module")
def its_controller(biped: Robot) -> Controller:
    return compile_controller(biped, on_compile=lambda: None)


def test_it_is_another_kind_of_robot(biped: Robot, robot: Robot) -> None:
    assert biped.n == 12
    assert not set(biped.joint_names) & set(robot.joint_names)
    kinds = {joint.shortname() for joint in biped.model.joints}
    assert {"JointModelRevoluteUnaligned", "JointModelPrismaticUnaligned"} <= kinds
    names = [part.name for part in (*biped.description.contacts, *biped.description.tasks)]
    others = [part.name for part in (*robot.description.contacts, *robot.description.tasks)]
    assert not set(names) & set(others)


def test_urdf_and_scene_are_the_same_body(biped: Robot) -> None:
    model = mujoco.MjModel.from_xml_path(str(biped.scene_path))
    in_scene = [model.joint(index).name for index in range(1, model.njnt)]
    assert in_scene != biped.joint_names
    assert sorted(in_scene) == sorted(biped.joint_names)
    parity = measure_parity(biped, model, states=20)
    assert max(vars(parity).values()) < 1e-9


def test_it_stands_at_home(biped: Robot, its_controller: Controller) -> None:
    tick = its_controller.tick(biped.home, its_controller.command())
    assert tick.status == Status.OK
    assert list(tick.wrenches) == ["near_ground", "far_ground"]
    pushes = [wrench[2] for wrench in tick.wrenches.values()]
    assert min(pushes) > 0.4 * biped.weight
    assert sum(pushes) == pytest.approx(biped.weight, rel=1e-6)
    assert np.abs(tick.qdd).max() < 1e-3


def test_it_stands_on_either_foot(biped: Robot, its_controller: Controller) -> None:
    for lifted, standing in (("near_ground", "far_ground"), ("far_ground", "near_ground")):
        command = its_controller.command()
        command[f"{lifted}.active"] = 0.0
        tick = its_controller.tick(biped.home, command)
        assert tick.status == Status.OK
        assert np.abs(tick.wrenches[lifted]).max() < 1e-9
        assert tick.wrenches[standing][2] > 0.5 * biped.weight


@pytest.mark.parametrize("extension", [1e7, 1e8, 1e9])
def test_legs_of_absurd_length_are_answered_safely(
    extension: float, biped: Robot, its_controller: Controller
) -> None:
    q = biped.home.q.copy()
    for joint in ("near_slide", "far_slide"):
        q[7 + biped.joint_names.index(joint)] = extension
    tick = its_controller.tick(State(q, biped.home.v), its_controller.command())
    assert tick.status in (Status.SINGULAR, Status.NOT_FINITE)
    assert np.isfinite(tick.reply).all()
    assert (np.abs(tick.tau) <= biped.torque_limit).all()


def test_it_squats(biped: Robot, its_controller: Controller) -> None:
    run = MujocoSimulator(biped).run(its_controller, Squat(0.03, 1.0), laps=2)
    assert not run.fell
    assert run.failures == {}
    assert run.steady
    assert run.laps_run <= 6
    assert run.peak_error < 1e-3
    heights = run.log["reference"][run.log["measured"]]
    assert np.ptp(heights) == pytest.approx(0.06, rel=1e-2)


def sources() -> list[Path]:
    folders = ("tsd_casadi", "server", "clients", "binding")
    return [
        path
        for folder in folders
        for ending in ("*.py", "*.pyi", "*.c", "*.h", "*.cpp", "*.hpp")
        for path in (ROOT / folder).rglob(ending)
    ]


def test_no_source_knows_a_robot_by_name() -> None:
    names = list(tsd_models.robot_files())
    assert names
    found = []
    for path in sources():
        for number, line in enumerate(path.read_text().splitlines(), start=1):
            if path.name == "options.py":
                line = re.sub(r"^ROBOT = .*", "", line)
            if any(name in line for name in names):
                found.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()}")
    assert found == []


def test_the_search_sees_every_package() -> None:
    assert {"robot.py", "tick.c", "symbolic_model.cpp", "service.py", "simulator.py"} <= {
        path.name for path in sources()
    }
