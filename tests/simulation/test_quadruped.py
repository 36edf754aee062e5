from __future__ import annotations

import shutil
from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml

from tsd_casadi import (
    Command,
    Controller,
    Database,
    Robot,
    Squat,
    Status,
    compile_controller,
    learn,
    load_robot,
)
from tsd_casadi.motions.hold import hold
from tsd_casadi.robot.description_path import find_package
from tsd_casadi.robot.reaching import reach
from tsd_clients import MujocoSimulator
from tsd_clients.simulator.parity import measure_parity
from tsd_clients.simulator.static_poses import collect, true_center_of_mass

LEGS = ("fl", "fr", "rl", "rr")
# of mini_quadruped in the URDF's terms [m]
RADIUS = 0.02


@pytest.fixture(scope="module")
def quadruped(mini_quadruped: Robot) -> Controller:
    return compile_controller(mini_quadruped, on_compile=lambda: None)


def pushes(simulator: MujocoSimulator, data: mujoco.MjData) -> dict[str, float]:
    """Normal force of MuJoCo's contacts, by leg [N]."""
    model, found, wrench = simulator.model, dict.fromkeys(LEGS, 0.0), np.empty(6)
    for index in range(data.ncon):
        mujoco.mj_contactForce(model, data, index, wrench)
        (ball,) = (g for g in data.contact[index].geom if model.geom(g).name != "ground")
        found[model.geom(ball).name.removesuffix("_ball")] += wrench[0]
    return found


def test_urdf_and_scene_are_the_same_body(mini_quadruped: Robot) -> None:
    model = mujoco.MjModel.from_xml_path(str(mini_quadruped.scene_path))
    parity = measure_parity(mini_quadruped, model, states=20)
    assert max(vars(parity).values()) < 1e-9


def test_at_home_each_point_is_where_its_ball_touches(mini_quadruped: Robot) -> None:
    simulator = MujocoSimulator(mini_quadruped)
    data = mujoco.MjData(simulator.model)
    simulator.state_map.write(data, mini_quadruped.home)
    mujoco.mj_kinematics(simulator.model, data)
    for leg, place in zip(LEGS, mini_quadruped.sole_placements(mini_quadruped.home.q), strict=True):
        lowest = data.geom(f"{leg}_ball").xpos - [0, 0, RADIUS]
        np.testing.assert_allclose(place.translation, lowest, atol=1e-12)


def test_it_stands_at_home(mini_quadruped: Robot, quadruped: Controller) -> None:
    tick = quadruped.tick(mini_quadruped.home, quadruped.command())
    assert (tick.status, tick.active) == (Status.OK, [])
    assert list(tick.wrenches) == [f"{leg}_ground" for leg in LEGS]
    assert sum(w[2] for w in tick.wrenches.values()) == pytest.approx(
        mini_quadruped.weight, rel=1e-6
    )
    assert min(w[2] for w in tick.wrenches.values()) > 0.2 * mini_quadruped.weight
    assert not any(w[3:].any() for w in tick.wrenches.values())
    assert np.abs(tick.qdd).max() < 1e-3


def test_the_ground_carries_what_the_controller_plans(
    mini_quadruped: Robot, quadruped: Controller
) -> None:
    # forces in world axes: those of MuJoCo's contacts, foot by foot
    simulator = MujocoSimulator(mini_quadruped)
    simulator.start(mini_quadruped.home)
    command = quadruped.command()
    for _ in range(1500):
        tick = quadruped.tick(simulator.measure(), command)
        simulator.apply(tick.tau)
    assert simulator._body is not None
    found = pushes(simulator, simulator._body._data)
    for leg in LEGS:
        planned = tick.wrenches[f"{leg}_ground"][2]
        assert found[leg] == pytest.approx(planned, rel=1e-2)


def test_it_squats(mini_quadruped: Robot, quadruped: Controller) -> None:
    run = MujocoSimulator(mini_quadruped).run(quadruped, Squat(0.03, 1.0), laps=2)
    assert not run.fell
    assert run.failures == {}
    assert run.steady
    assert run.laps_run <= 6
    # without a model error: what remains is that balls roll and the ground gives way
    assert run.errors["mass.z"].peak < 2e-3
    heights = run.along("reference", "mass.z")[run.log["measured"]]
    assert np.ptp(heights) == pytest.approx(0.06, rel=1e-2)


@pytest.mark.parametrize(("rule", "once", "twice"), [("plain", 10, 150), ("stable", 100, 5000)])
def test_it_learns(
    rule: str,
    once: float,
    twice: float,
    mini_quadruped: Robot,
    quadruped: Controller,
    tmp_path: Path,
) -> None:
    with Database(tmp_path / "learned.sqlite") as database:
        runs = learn(
            MujocoSimulator(mini_quadruped, 0.1),
            quadruped,
            [Squat(0.03, 0.25)],
            database,
            axes=["mass.z"],
            iterations=2,
            rule=rule,  # type: ignore[arg-type]
        )
    errors = [run.errors["mass.z"].rms for run in runs]
    print([errors[0] / error for error in errors])
    assert errors[0] > 1e-2
    assert errors[0] / errors[1] > once
    assert errors[0] / errors[2] > twice


@pytest.mark.parametrize("leg", LEGS)
def test_it_stands_on_three_legs(leg: str, mini_quadruped: Robot, quadruped: Controller) -> None:
    # over the triangle of the others first, then one foot is switched off and lifted
    robot, simulator = mini_quadruped, MujocoSimulator(mini_quadruped)
    places = dict(zip(LEGS, robot.sole_placements(robot.home.q), strict=True))
    middle = np.mean([places[other].translation[:2] for other in LEGS if other != leg], axis=0)
    x, y = 0.6 * (middle - robot.home_com[:2])
    over = reach(robot, robot.home, {"mass.x": x, "mass.y": y})
    assert over is not None
    simulator.start(over)
    command = quadruped.command()
    hold(command, robot, over)
    command[f"{leg}_ground.active"] = 0.0
    bend = robot.joint_names.index(f"{leg}_bend")
    command["posture.q_ref"][bend] -= 0.3
    for _ in range(2000):
        tick = quadruped.tick(simulator.measure(), command)
        assert tick.status == Status.OK
        assert np.abs(tick.wrenches[f"{leg}_ground"]).max() < 1e-9
        simulator.apply(tick.tau)
    truth = simulator.truth()
    assert truth is not None
    assert simulator._body is not None
    found = pushes(simulator, simulator._body._data)
    assert found.pop(leg) == 0.0
    assert min(found.values()) > 1.0
    np.testing.assert_allclose(truth.com, robot.center_of_mass(over.q), atol=5e-3)
    lifted = dict(zip(LEGS, robot.sole_placements(truth.state.q), strict=True))[leg]
    assert lifted.translation[2] > 0.02


def test_two_feet_on_a_diagonal_cannot_hold_what_is_beside_it(
    mini_quadruped: Robot, quadruped: Controller
) -> None:
    # forces on a line make no moment about it, so the robot tips: a solution, and said so
    beside = reach(mini_quadruped, mini_quadruped.home, {"mass.y": 0.03})
    assert beside is not None
    command = quadruped.command()
    hold(command, mini_quadruped, beside)
    assert np.abs(quadruped.tick(beside, command).qdd).max() < 1e-2
    for leg in ("fl", "rr"):
        command[f"{leg}_ground.active"] = 0.0
    tick = quadruped.tick(beside, command)
    assert tick.status == Status.OK
    line = [tick.wrenches[f"{leg}_ground"][2] > 0.1 * mini_quadruped.weight for leg in ("fr", "rl")]
    assert line == [True, True]
    assert np.abs(tick.qdd[:6]).max() > 0.3


def test_more_force_than_three_legs_may_carry_is_infeasible(
    mini_quadruped: Robot, quadruped: Controller
) -> None:
    def ask(command: Command, least: float) -> Status:
        for leg in LEGS[:3]:
            command[f"{leg}_ground.minimum_force"] = least
        command["rr_ground.active"] = 0.0
        command["limits.acceleration"] = 1.0
        return quadruped.tick(mini_quadruped.home, command).status

    assert ask(quadruped.command(), 0.1 * mini_quadruped.weight) == Status.OK
    assert ask(quadruped.command(), 10 * mini_quadruped.weight) == Status.INFEASIBLE


# real ones, of example-robot-data, in scenes that are made in memory
REAL = {
    path.stem: path
    for name in ("go2", "solo12")
    for path in (Path(__file__).parents[1] / "robots" / name).glob("*.yaml")
}


@pytest.fixture(scope="module", params=REAL)
def real(request: pytest.FixtureRequest) -> Robot:
    if find_package("example-robot-data") is None:
        pytest.skip("example-robot-data is not installed")
    return load_robot(REAL[request.param])


def test_real_quadrupeds_stand_squat_and_learn(real: Robot, tmp_path: Path) -> None:
    controller = compile_controller(real, on_compile=lambda: None)
    tick = controller.tick(real.home, controller.command())
    assert (tick.status, tick.active) == (Status.OK, [])
    assert sum(w[2] for w in tick.wrenches.values()) == pytest.approx(real.weight, rel=1e-6)
    with Database(tmp_path / "learned.sqlite") as database:
        runs = learn(
            MujocoSimulator(real, 0.1),
            controller,
            [Squat(0.03, 0.25)],
            database,
            axes=["com.z"],
            iterations=2,
            rule="stable",
        )
    assert all(run.failures == {} for run in runs)
    errors = [run.errors["com.z"].rms for run in runs]
    print(real.name, [errors[0] / error for error in errors])
    assert errors[0] > 1e-2
    assert errors[0] / errors[1] > 100
    assert errors[0] / errors[2] > 5000


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (1.2, -0.7, 2.0)])
def test_a_ball_is_made_under_the_point_however_its_frame_is_turned(
    turn: tuple[float, float, float], mini_quadruped: Robot, tmp_path: Path
) -> None:
    folder = shutil.copytree(mini_quadruped.path.parent, tmp_path / "mini_quadruped")
    path = Path(folder) / mini_quadruped.path.name
    document = yaml.safe_load(path.read_text())
    del document["scene"]
    for contact in document["contacts"]:
        contact["offset"] = {"rpy": list(turn)}
    path.write_text(yaml.safe_dump(document))
    robot = load_robot(path)
    simulator = MujocoSimulator(robot)
    data = mujoco.MjData(simulator.model)
    simulator.state_map.write(data, robot.home)
    mujoco.mj_forward(simulator.model, data)
    assert data.ncon == 4
    # as deep as the rounding of the home posture, and straight below the points
    for place in robot.sole_placements(robot.home.q):
        assert np.linalg.norm(data.contact.pos - place.translation, axis=1).min() < 1e-6


def test_its_static_poses_tell_the_centre_of_mass(
    mini_quadruped: Robot, quadruped: Controller
) -> None:
    simulator = MujocoSimulator(mini_quadruped)
    # where the trunk leans far the balls have rolled up: such poses are left out
    poses = collect(simulator, quadruped, count=6)
    assert len(poses) >= 3
    for pose in poses:
        center = true_center_of_mass(simulator, pose.q)[:2]
        np.testing.assert_allclose(pose.center_of_pressure, center, atol=1e-3)
        assert pose.weight == pytest.approx(mini_quadruped.weight, rel=1e-2)
