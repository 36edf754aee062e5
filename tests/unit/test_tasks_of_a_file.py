"""What a robot file may have under 'tasks', up to the compiled tick."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import pytest
import yaml

from tsd_casadi import Command, Controller, InverseDynamics, Robot, Status, Tick, load_robot
from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.exceptions import RobotFileError

WriteRobot = Callable[..., Path]
SPIN = {"type": "angular_momentum", "name": "spin", "D": 10.0, "W": 1.0}
PRESS = {"type": "contact_force", "name": "press", "contact": "left_foot", "W": 1.0e-3}
P = [[50.0, 5.0, 0.0], [5.0, 60.0, -4.0], [0.0, -4.0, 70.0]]


def with_tasks(*tasks: Any, **com: Any) -> Callable[[Any], object]:
    def edit(document: Any) -> None:
        document["tasks"][0].update(com)
        document["tasks"] += tasks

    return edit


@pytest.fixture(scope="module")
def robot_with_all(tmp_path_factory: pytest.TempPathFactory, robot: Robot) -> Robot:
    folder = tmp_path_factory.mktemp("all")
    document = yaml.safe_load(robot.path.read_text())
    document["urdf"] = "robot.urdf"
    document.pop("scene")
    with_tasks({**SPIN, "active": False}, {**PRESS, "axes": ["z", "rx"]}, P=P)(document)
    (folder / "robot.urdf").write_text(robot.source_path.read_text())
    (folder / "all.yaml").write_text(yaml.safe_dump(document))
    return load_robot(folder / "all.yaml")


@pytest.fixture(scope="module")
def problem(robot_with_all: Robot) -> InverseDynamics:
    return InverseDynamics(robot_with_all)


@pytest.fixture(scope="module")
def controller(robot_with_all: Robot) -> Controller:
    return compile_controller(robot_with_all, on_compile=lambda: None)


def run(controller: Controller, command: Command) -> Tick:
    tick = Tick(controller.format, controller.run(command.request))
    assert tick.status == Status.OK
    return tick


def test_the_compiled_tick_is_the_optimum_of_the_definition(
    problem: InverseDynamics, controller: Controller
) -> None:
    rng = np.random.default_rng(0)
    for level in (0.0, 0.4, 1.0):
        command = controller.command()
        command["q"], command["v"] = problem.robot.home.q, 0.02 * rng.normal(size=problem.nv)
        command["spin.active"], command["press.active"] = level, rng.random()
        command["spin.reference_velocity"] = rng.normal(scale=0.1, size=3)
        tick = run(controller, command)
        assert tick.active == []
        program, meq = problem.evaluate(command.request), problem.n_equalities
        E, e = program.A[:meq], program.lower[problem.nv :][:meq]
        kkt = np.block([[program.H, E.T], [E, np.zeros((meq, meq))]])
        x = np.linalg.solve(kkt, np.concatenate((-program.g, e)))[: problem.nx]
        np.testing.assert_allclose(tick.qdd, x[: problem.nv], atol=1e-6)
        np.testing.assert_allclose(
            np.concatenate([*tick.wrenches.values()]), x[problem.nv :], atol=1e-4
        )


def test_gains_of_a_file_are_matrices_in_the_command(
    robot_with_all: Robot, controller: Controller
) -> None:
    command = controller.command()
    np.testing.assert_array_equal(command["com.P"], np.diag(P))
    np.testing.assert_array_equal(command["com.P_coupling"], [5.0, 0.0, -4.0])
    command["q"], command["v"] = robot_with_all.home.q, robot_with_all.home.v
    error = np.array([0.01, -0.02, 0.005])
    command["com.reference"] = robot_with_all.home_com + error
    found = run(controller, command)
    np.testing.assert_allclose(found.feedback[:3], np.array(P) @ error, atol=1e-9)


def test_angular_momentum_is_taken_out(robot_with_all: Robot, controller: Controller) -> None:
    model, data = robot_with_all.model, robot_with_all.model.createData()
    command = controller.command()
    q, v = robot_with_all.home.q, np.zeros(robot_with_all.nv)
    v[robot_with_all.joint_names.index("B_TR") + 6] = 0.5
    command["q"], command["v"] = q, v
    for name in ("pelvis", "torso"):  # the feet stand and the body is free to turn
        command[f"{name}.active"] = 0.0
    command["spin.mask"] = [0.0, 0.0, 1.0]
    rates = []
    for active in (0.0, 1.0):
        command["spin.active"] = active
        tick = run(controller, command)
        pinocchio.computeCentroidalMomentumTimeVariation(model, data, q, v, tick.qdd)
        rates.append(float(data.dhg.angular[2]))
    momentum = float(data.hg.angular[2])
    assert rates[1] == pytest.approx(-10.0 * momentum, rel=0.05)
    assert abs(rates[0] + 10.0 * momentum) > 5 * abs(rates[1] + 10.0 * momentum)
    spin = controller.format.axis_index("spin", "rz")
    assert tick.error[spin] == pytest.approx(-momentum / robot_with_all.home_inertia)


def test_a_contact_carries_what_it_is_asked_to(controller: Controller, robot: Robot) -> None:
    command = controller.command()
    command["q"], command["v"] = robot.home.q, robot.home.v
    share = robot.weight / 2
    assert command["press.reference"] == pytest.approx([share, 0.0])
    command["com.active"] = 0.0  # which way the weight goes is decided by the feet
    command["press.reference"][0] = share + 60.0
    carried = []
    for level in np.linspace(0, 1, 51):
        command["press.active"] = level
        carried.append(run(controller, command).wrenches["left_foot"][2])
    assert abs(carried[0] - share) < 10.0
    assert carried[-1] == pytest.approx(share + 60.0, abs=1.0)
    steps = np.diff(carried)
    assert np.abs(steps).max() < 4 * (carried[-1] - carried[0]) / len(steps)
    command["press.mask"] = [0.0, 1.0]
    assert run(controller, command).wrenches["left_foot"][2] == pytest.approx(carried[0], abs=1.0)


def test_tasks_without_a_place_change_the_formulation_and_no_other_robot(
    write_robot: WriteRobot, robot: Robot
) -> None:
    found = {robot.formulation_fingerprint, load_robot(write_robot()).formulation_fingerprint}
    assert len(found) == 1
    for task in (SPIN, {**SPIN, "active": False}, PRESS, {**PRESS, "W": 1.0}):
        found.add(load_robot(write_robot(with_tasks(task))).formulation_fingerprint)
    assert len(found) == 5
    gains = load_robot(write_robot(with_tasks(P=P)))
    assert gains.formulation_fingerprint == robot.formulation_fingerprint
    assert [task.name for task in gains.description.tasks] == ["com", "pelvis", "torso"]


@pytest.mark.parametrize(
    ("edit", "told"),
    [
        (with_tasks(P=[1.0, 2.0]), r"tasks\.0\.P': is .*3 of them for the axes x y z"),
        (with_tasks(P=[1.0, -2.0, 3.0]), r"tasks\.0\.P\.1': is -2"),
        (with_tasks(D=[[1.0, 0.0], [0.0, 1.0]]), r"tasks\.0\.D': is .*3 rows of 3"),
        (with_tasks(D=[[1, 2, 0], [0, 1, 0], [0, 0, 1]]), r"tasks\.0\.D': is .*a symmetric matrix"),
        (
            with_tasks(P=[[1, 2, 0], [2, 1, 0], [0, 0, 1]]),
            r"tasks\.0\.P': is .*negative",
        ),
        (with_tasks(P=-1.0), r"tasks\.0\.P': is -1"),
        (with_tasks(P="high"), r"tasks\.0\.P': is 'high'"),
        (with_tasks({**SPIN, "P": 1.0}), r"tasks\.3\.P': is not a known field"),
        (with_tasks({**SPIN, "axes": ["x"]}), r"tasks\.3\.axes\.0': is 'x'"),
        (with_tasks({**PRESS, "contact": "left_fot"}), r"tasks\.3\.contact.*left_foot"),
        (with_tasks({**PRESS, "axes": []}), r"tasks\.3\.axes': is \[\]"),
        (with_tasks({**PRESS, "name": "com"}), r"the name 'com' is used twice"),
    ],
)
def test_what_does_not_fit_is_refused(
    edit: Callable[[Any], object], told: str, write_robot: WriteRobot
) -> None:
    with pytest.raises(RobotFileError, match=told):
        load_robot(write_robot(edit))


def test_a_gain_is_symmetric_and_semidefinite_up_to_rounding(write_robot: WriteRobot) -> None:
    def off(by: float) -> list[list[float]]:
        return [[1.0, 1.0 + by, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]

    load_robot(write_robot(with_tasks(P=off(0.9e-6))))
    with pytest.raises(RobotFileError, match="symmetric"):
        load_robot(write_robot(with_tasks(P=off(1.1e-6))))


def test_a_point_has_no_moment_to_ask_for(mini_quadruped: Robot, tmp_path: Path) -> None:
    document = yaml.safe_load(mini_quadruped.path.read_text())
    document["urdf"], document["scene"] = str(mini_quadruped.source_path.name), None
    contact = mini_quadruped.description.contacts[0].name
    document["tasks"].append({**PRESS, "contact": contact, "axes": ["z", "rx"]})
    (tmp_path / document["urdf"]).write_text(mini_quadruped.source_path.read_text())
    path = tmp_path / "robot.yaml"
    path.write_text(yaml.safe_dump(document))
    with pytest.raises(RobotFileError, match="of a point, which carries no moment"):
        load_robot(path)
