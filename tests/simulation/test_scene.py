from __future__ import annotations

from pathlib import Path
from typing import Any

import hypothesis
import mujoco
import numpy as np
import pinocchio
import pytest
import yaml
from hypothesis import strategies as st

from tsd_casadi import Controller, Database, Robot, Squat, compile_controller, learn, load_robot
from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.description_path import find_package
from tsd_casadi.robot.robot_file_sections import PointFile
from tsd_clients import MujocoSimulator
from tsd_clients.simulator import scene
from tsd_clients.simulator.build_scene import LEAST, build_scene
from tsd_clients.simulator.feet import RADIUS, THICKNESS
from tsd_clients.simulator.mujoco_plant import MujocoPlant
from tsd_clients.simulator.parity import find_discrepancies, measure_parity, random_state
from tsd_clients.simulator.scene import load_scene, scene_file
from tsd_clients.simulator.state_map import StateMap

DATA = "example-robot-data"
GAINS: dict[str, Any] = {
    "posture": {"P": 40.0, "D": 12.0, "W": 0.01},
    "regularization": {"force": 1e-6, "moment": 1e-5, "acceleration": 1e-5},
    "limits": {"acceleration": 500.0},
    "safe_torque": {"D": 5.0},
}
GROUND = {"friction": 0.5, "torsional_friction": 0.05, "minimum_force": 5.0}
COM = {"type": "com", "name": "com", "P": 50.0, "D": 14.142135623730951, "W": 10.0}
UPRIGHT = {"type": "frame", "axes": ["rx", "ry", "rz"], "P": 100.0, "D": 20.0, "W": 1.0}
FOREIGN: dict[str, dict[str, Any]] = {
    "g1": {
        "urdf": f"package://{DATA}/robots/g1_description/urdf/g1_29dof_rev_1_0.urdf",
        "home": {
            f"{side}_{joint}_joint": angle
            for side in ("left", "right")
            for joint, angle in {
                "hip_pitch": -0.6,
                "knee": 1.2,
                "ankle_pitch": -0.6,
                "elbow": 0.6,
            }.items()
        },
        "contacts": [
            {
                "name": f"{side}_foot",
                "frame": f"{side}_ankle_roll_link",
                "offset": {"xyz": [0.035, 0.0, -0.035]},
                "x": [-0.08, 0.08],
                "y": [-0.025, 0.025],
                **GROUND,
            }
            for side in ("left", "right")
        ],
        "tasks": [
            COM,
            {"name": "pelvis", "frame": "pelvis", **UPRIGHT},
            {"name": "torso", "frame": "torso_link", **UPRIGHT},
        ],
    },
    "talos": {
        "urdf": f"package://{DATA}/robots/talos_data/robots/talos_reduced.urdf",
        "locked": {"gripper.*": -0.3, "head.*": 0.0},
        "home": {
            **{
                f"leg_{side}_{joint}_joint": angle
                for side in ("left", "right")
                for joint, angle in {3: -0.6, 4: 1.2, 5: -0.6}.items()
            },
            "arm_left_4_joint": -0.6,
            "arm_right_4_joint": -0.6,
        },
        "contacts": [
            {
                "name": f"{side}_foot",
                "frame": f"{side}_sole_link",
                "x": [-0.09, 0.09],
                "y": [-0.05, 0.05],
                **GROUND,
            }
            for side in ("left", "right")
        ],
        "tasks": [
            COM,
            {"name": "pelvis", "frame": "base_link", **UPRIGHT},
            {"name": "torso", "frame": "torso_2_link", **UPRIGHT},
        ],
    },
}


def without_scene(robot: Robot, folder: Path) -> Robot:
    """The same robot whose file names no scene."""
    document = yaml.safe_load(robot.path.read_text())
    del document["scene"]
    (folder / robot.source_path.name).write_text(robot.source_path.read_text())
    path = folder / robot.path.name
    path.write_text(yaml.safe_dump(document))
    return load_robot(path)


@pytest.fixture(scope="module", params=["hermes_lower", "mini_biped"])
def both(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A robot with its scene, and the same without one."""
    given = request.getfixturevalue("robot" if request.param == "hermes_lower" else request.param)
    return given, without_scene(given, tmp_path_factory.mktemp(request.param))


@pytest.fixture(scope="module")
def bare(both: tuple[Robot, Robot]) -> Robot:
    return both[1]


@pytest.fixture(scope="module")
def built(bare: Robot) -> Any:
    return build_scene(bare).compile()


@pytest.fixture(scope="module", params=FOREIGN)
def foreign(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Robot:
    if find_package(DATA) is None:
        pytest.skip(f"{DATA} is not installed")
    path = tmp_path_factory.mktemp(request.param) / f"{request.param}.yaml"
    path.write_text(yaml.safe_dump({"name": request.param, **FOREIGN[request.param], **GAINS}))
    return load_robot(path)


# rigid bodies: Pinocchio's against MuJoCo's


@hypothesis.given(st.integers(0, 10**6))
def test_bodies_are_pinocchios_to_rounding(bare: Robot, built: Any, seed: int) -> None:
    parity = measure_parity(bare, built, states=1, seed=seed)
    assert parity.mass_matrix < 1e-12
    assert parity.bias_forces < 1e-11
    assert parity.center_of_mass < 1e-14


def test_a_public_humanoid_agrees_too(foreign: Robot) -> None:
    model = build_scene(foreign).compile()
    assert find_discrepancies(foreign, model) == []
    parity = measure_parity(foreign, model, states=20)
    assert parity.mass_matrix < 1e-12
    assert parity.bias_forces < 1e-11
    assert parity.center_of_mass < 1e-14


def test_a_built_scene_passes_what_given_ones_are_asked(bare: Robot, built: Any) -> None:
    assert find_discrepancies(bare, built) == []


def test_motors_give_what_the_controller_may_ask_for_and_no_more(bare: Robot, built: Any) -> None:
    state_map = StateMap(bare, built)
    data = mujoco.MjData(built)
    state_map.write(data, bare.home)
    for factor in (0.5, 2.0):
        data.ctrl[state_map.actuators] = factor * bare.torque_limit
        mujoco.mj_forward(built, data)
        applied = data.qfrc_actuator[state_map.v_joints]
        np.testing.assert_allclose(applied, min(factor, 1.0) * bare.torque_limit, rtol=1e-12)


def test_nothing_passive_acts_and_only_feet_collide(bare: Robot, built: Any) -> None:
    data = mujoco.MjData(built)
    state_map = StateMap(bare, built)
    rng = np.random.default_rng(0)
    for _ in range(20):
        state = random_state(bare, rng)
        state.q[2] = 5.0  # in the air, whatever the legs do
        state_map.write(data, state)
        mujoco.mj_forward(built, data)
        assert not data.qfrc_passive.any()
        assert data.ncon == 0


def test_contacts_and_options_are_those_of_scenes_by_hand(both: tuple[Robot, Robot]) -> None:
    given = mujoco.MjModel.from_xml_path(str(both[0].scene_path))
    built = build_scene(both[1]).compile()
    for option in ("timestep", "integrator", "cone", "impratio", "solver", "iterations"):
        assert getattr(built.opt, option) == getattr(given.opt, option), option
    touching = []
    for robot, model in zip(both, (given, built), strict=True):
        data = mujoco.MjData(model)
        StateMap(robot, model).write(data, robot.home)
        data.qpos[2] -= 1e-4
        mujoco.mj_forward(model, data)
        assert data.ncon == 8
        touching.append([(c.dim, *c.friction, *c.solref, *c.solimp) for c in data.contact])
    np.testing.assert_array_equal(*touching)


# feet


def test_a_sole_is_where_the_file_has_it_and_as_large(bare: Robot, built: Any) -> None:
    data = mujoco.MjData(built)
    StateMap(bare, built).write(data, bare.home)
    mujoco.mj_kinematics(built, data)
    for contact, sole in zip(
        bare.description.contacts, bare.sole_placements(bare.home.q), strict=True
    ):
        geom = built.geom(contact.name)
        np.testing.assert_allclose(2 * geom.size[:2], [np.ptp(contact.x), np.ptp(contact.y)])
        middle = sole.act(np.array([np.mean(contact.x), np.mean(contact.y), THICKNESS / 2]))
        np.testing.assert_allclose(data.geom(contact.name).xpos, middle, atol=1e-12)


def test_a_point_is_a_sphere_that_touches_there(
    bare: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = tuple(
        PointFile(type="point", name=sole.name, frame=sole.frame, friction=0.5, minimum_force=1.0)
        for sole in bare.description.contacts
    )
    described = bare.description.model_copy(update={"contacts": points})
    monkeypatch.setattr(bare, "description", described)
    model = build_scene(bare).compile()
    assert find_discrepancies(bare, model) == []
    data = mujoco.MjData(model)
    StateMap(bare, model).write(data, bare.home)
    mujoco.mj_kinematics(model, data)
    for point, sole in zip(points, bare.sole_placements(bare.home.q), strict=True):
        touching = data.geom(point.name).xpos - [0, 0, RADIUS]
        np.testing.assert_allclose(touching, sole.translation, atol=1e-12)


def test_a_public_humanoid_stands_on_its_soles(foreign: Robot) -> None:
    model = load_scene(foreign)
    # light hands on stiff joints would need shorter steps
    model.dof_armature[6:] = 0.1
    plant = MujocoPlant(foreign, model, foreign.home, foreign.home, (), (), seed=0)
    tau = _standing_torque(foreign)
    forces = []
    for tick in range(1000):
        true, _ = plant.measure()
        off = pinocchio.difference(foreign.model, foreign.home.q, true.q)[6:]
        plant.step(tau - 2000.0 * off - 50.0 * true.v[6:], 1e-3 * tick)
        forces.append(plant.ground_force()[0])
    assert np.mean(forces[-200:], axis=0)[2] == pytest.approx(foreign.weight, rel=1e-3)
    np.testing.assert_allclose(plant.com, foreign.home_com, atol=5e-3)


def _standing_torque(robot: Robot) -> Any:
    """Torques at rest, the least wrenches on the soles."""
    data = robot.model.createData()
    q = robot.home.q
    gravity = pinocchio.computeGeneralizedGravity(robot.model, data, q)
    J = np.vstack(
        [
            pinocchio.computeFrameJacobian(robot.model, data, q, frame, pinocchio.LOCAL)
            for frame in robot.sole_frames
        ]
    )
    wrenches = np.linalg.lstsq(J[:, :6].T, gravity[:6], rcond=None)[0]
    return (gravity - J.T @ wrenches)[6:]


# where there is a scene, and where not


def test_the_scene_of_the_file_is_taken_where_there_is_one(both: tuple[Robot, Robot]) -> None:
    given, bare = both
    assert given.scene_path is not None
    assert load_scene(given).ngeom == mujoco.MjModel.from_xml_path(str(given.scene_path)).ngeom
    assert scene_file(given) == given.scene_path
    assert bare.scene_path is None
    assert load_scene(bare).ngeom == 1 + len(bare.description.contacts)
    assert scene_file(bare) == bare.path


def test_what_mujoco_refuses_is_told_of_the_robots_file(
    bare: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(robot: Robot) -> Any:
        raise ValueError("Error: mass is\ntoo heavy")

    monkeypatch.setattr(scene, "build_scene", refuse)
    with pytest.raises(RobotFileError, match="mass is too heavy") as caught:
        load_scene(bare)
    assert caught.value.path == bare.path


# bodies at the edge of what there is


def _changed(robot: Robot, inertia: Any) -> Any:
    """The compiled scene of a robot whose last body has another inertia."""
    kept = robot.model.inertias[robot.model.njoints - 1].copy()
    robot.model.inertias[robot.model.njoints - 1] = inertia
    try:
        model = build_scene(robot).compile()
        return model, measure_parity(robot, model)
    finally:
        robot.model.inertias[robot.model.njoints - 1] = kept


FLAT = {
    "a plate": np.diag([1e-3, 2e-3, 3e-3]),
    "a plate of six digits": np.diag([1e-3, 2e-3, 3e-3 * (1 + 0.9e-5)]),
    "a rod": np.diag([1e-3, 1e-3, 1e-18]),
}


@pytest.mark.parametrize("what", FLAT)
def test_flat_bodies_are_taken_however_they_are_rounded(bare: Robot, what: str) -> None:
    for turn in np.linspace(0, 3, 20):
        R = pinocchio.rpy.rpyToMatrix(turn, 2 * turn, 3 * turn)
        inertia = pinocchio.Inertia(0.5, np.array([0.01, 0.02, 0.03]), R @ FLAT[what] @ R.T)
        _, parity = _changed(bare, inertia)
        assert parity.mass_matrix < 1e-7


def test_rotors_of_the_description_are_in_the_scene(bare: Robot) -> None:
    bare.model.armature[6:] = np.linspace(0.01, 0.2, bare.n)
    try:
        model = build_scene(bare).compile()
        assert find_discrepancies(bare, model) == []
        assert measure_parity(bare, model).mass_matrix < 1e-12
        model.dof_armature[8] = 0.0
        (found,) = find_discrepancies(bare, model)
        assert (found.quantity, found.found) == ("armature", "0 kg m^2")
        assert found.remedy.startswith('set armature="0.')
    finally:
        bare.model.armature[6:] = 0.0


def test_a_link_without_mass_gets_next_to_none(bare: Robot) -> None:
    last = bare.model.njoints - 1
    kept = bare.model.inertias[last - 1].copy()
    bare.model.inertias[last - 1] = pinocchio.Inertia.Zero()
    try:
        model = build_scene(bare).compile()
        assert find_discrepancies(bare, model) == []
        assert measure_parity(bare, model).mass_matrix < 10 * LEAST
    finally:
        bare.model.inertias[last - 1] = kept


# learning


SHORT = Squat(0.02, 1.0)


def _learned(
    robot: Robot, controller: Controller, folder: Path, rule: Any, squat: Squat = SHORT
) -> list[float]:
    axis = f"{next(task.name for task in robot.description.tasks if task.type == 'com')}.z"
    with Database(folder / "learned.sqlite") as database:
        runs = learn(
            MujocoSimulator(robot, 0.1),
            controller,
            [squat],
            database,
            axes=(axis,),
            iterations=2,
            rule=rule,
        )
    return [run.errors[axis].rms for run in runs]


def test_learning_does_not_tell_the_scenes_apart(both: tuple[Robot, Robot], tmp_path: Path) -> None:
    controller = compile_controller(both[0], on_compile=lambda: None)
    errors = []
    for name, robot in zip(("given", "built"), both, strict=True):
        (tmp_path / name).mkdir()
        errors.append(_learned(robot, controller, tmp_path / name, "plain"))
    given, built = errors
    assert given[1] < 0.1 * given[0]
    np.testing.assert_allclose(built, given, rtol=1e-3)


@pytest.mark.long
@pytest.mark.parametrize("name", FOREIGN)
def test_a_shipped_humanoid_learns_in_the_scene_made_for_it(name: str, tmp_path: Path) -> None:
    if find_package(DATA) is None:
        pytest.skip(f"{DATA} is not installed")
    robot = load_robot(name)
    controller = compile_controller(robot, on_compile=lambda: None)
    before, first, second = _learned(robot, controller, tmp_path, "stable", Squat(0.03, 0.25))
    assert before >= 200 * first
    assert before >= 20_000 * second


def test_a_simulator_needs_no_scene(bare: Robot) -> None:
    simulator = MujocoSimulator(bare, 0.1)
    assert 1.1 * float(simulator.model.body_mass.sum()) * 9.81 == pytest.approx(bare.weight)


def test_what_no_joint_of_mujocos_is_is_refused_by_name(
    bare: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    ball = pinocchio.Model()
    index = ball.addJoint(
        0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "root_joint"
    )
    ball.addJoint(index, pinocchio.JointModelSpherical(), pinocchio.SE3.Identity(), "hip")
    monkeypatch.setattr(bare, "model", ball)
    monkeypatch.setattr(bare.bodies, "link_of", lambda joint: f"link {joint}")
    with pytest.raises(RobotFileError, match="joint hip': is of the kind JointModelSpherical"):
        build_scene(bare)
