from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pinocchio
import pytest

from tsd_casadi import Robot, State, load_robot
from tsd_casadi.exceptions import RobotFileError
from tsd_clients.simulator.parity import random_state
from tsd_clients.simulator.scene import load_scene
from tsd_clients.simulator.state_map import StateMap

STATES = 50
EditScene = Callable[[Callable[[str], str]], Robot]


@pytest.fixture
def edit_scene(write_robot: Callable[..., Path]) -> EditScene:
    """hermes_lower with its MuJoCo file changed."""

    def edit(change: Callable[[str], str]) -> Robot:
        path = write_robot()
        scene = path.parent / "hermes_lower.xml"
        text = scene.read_text()
        changed = change(text)
        assert changed != text
        scene.write_text(changed)
        return load_robot(path)

    return edit


def scene_of(robot: Robot) -> Any:
    return load_scene(robot)


def random_states(robot: Robot) -> list[State]:
    rng = np.random.default_rng(1)
    return [random_state(robot, rng) for _ in range(STATES)]


def test_what_is_written_is_read_back(any_robot: Robot) -> None:
    model = scene_of(any_robot)
    state_map, data = StateMap(any_robot, model), mujoco.MjData(model)
    for state in random_states(any_robot):
        state_map.write(data, state)
        found = state_map.read(data)
        np.testing.assert_array_equal(found.q, state.q)
        np.testing.assert_allclose(found.v, state.v, atol=1e-14)


def test_reading_does_not_alias_the_simulation(robot: Robot) -> None:
    model = scene_of(robot)
    state_map, data = StateMap(robot, model), mujoco.MjData(model)
    before = state_map.read(data)
    q, v = before.q.copy(), before.v.copy()
    data.qpos[:] += 1
    data.qvel[:] += 1
    np.testing.assert_array_equal(before.q, q)
    np.testing.assert_array_equal(before.v, v)


def test_conventions_of_a_base_turned_left(robot: Robot) -> None:
    # a quarter turn about z: the base's x is the world's y
    model = scene_of(robot)
    state_map, data = StateMap(robot, model), mujoco.MjData(model)
    half = np.sqrt(0.5)
    q = np.concatenate(([1.0, 2.0, 3.0, 0.0, 0.0, half, half], np.arange(robot.n) / 100))
    v = np.concatenate(([1.0, 0.0, 0.0, 0.1, 0.2, 0.3], np.arange(robot.n) / 10))
    state_map.write(data, State(q, v))
    np.testing.assert_allclose(data.qpos[:7], [1, 2, 3, half, 0, 0, half])
    np.testing.assert_allclose(data.qvel[:6], [0, 1, 0, 0.1, 0.2, 0.3], atol=1e-12)
    for index, name in enumerate(robot.joint_names):
        assert data.joint(name).qpos[0] == index / 100
        assert data.joint(name).qvel[0] == index / 10


def test_points_of_the_body_are_where_pinocchio_has_them(any_robot: Robot) -> None:
    model = scene_of(any_robot)
    state_map, data = StateMap(any_robot, model), mujoco.MjData(model)
    pin_data = any_robot.model.createData()
    for state in random_states(any_robot)[:10]:
        state_map.write(data, state)
        mujoco.mj_kinematics(model, data)
        pinocchio.forwardKinematics(any_robot.model, pin_data, state.q)
        for name in any_robot.joint_names:
            placement = pin_data.oMi[any_robot.model.getJointId(name)]
            body = data.body(int(model.joint(name).bodyid[0]))
            np.testing.assert_allclose(body.xpos, placement.translation, atol=1e-9)
            np.testing.assert_allclose(body.xmat, placement.rotation.ravel(), atol=1e-9)


def test_velocity_transform_is_the_derivative_of_the_configuration(any_robot: Robot) -> None:
    model = scene_of(any_robot)
    state_map, data = StateMap(any_robot, model), mujoco.MjData(model)
    step = 1e-6
    for state in random_states(any_robot):
        state_map.write(data, state)
        velocity, q = data.qvel.copy(), []
        for signed in (-step, step):
            state_map.write(data, state)
            mujoco.mj_integratePos(model, data.qpos, velocity, signed)
            q.append(state_map.read(data).q)
        differences = pinocchio.difference(any_robot.model, *q) / (2 * step)
        T = state_map.velocity_transform(state)
        np.testing.assert_allclose(T @ velocity, differences, atol=1e-7)
        np.testing.assert_allclose(T @ velocity, state.v, atol=1e-12)


def test_velocity_transform_is_orthogonal(any_robot: Robot) -> None:
    state_map = StateMap(any_robot, scene_of(any_robot))
    for state in random_states(any_robot)[:5]:
        T = state_map.velocity_transform(state)
        np.testing.assert_allclose(T.T @ T, np.eye(any_robot.nv), atol=1e-12)


def test_transform_drift_is_the_derivative_of_the_transform(any_robot: Robot) -> None:
    model = scene_of(any_robot)
    state_map, data = StateMap(any_robot, model), mujoco.MjData(model)
    step = 1e-6
    for state in random_states(any_robot)[:10]:
        state_map.write(data, state)
        velocity, T = data.qvel.copy(), []
        for signed in (-step, step):
            state_map.write(data, state)
            mujoco.mj_integratePos(model, data.qpos, velocity, signed)
            T.append(state_map.velocity_transform(state_map.read(data)))
        derivative = (T[1] - T[0]) / (2 * step)
        np.testing.assert_allclose(
            state_map.transform_drift(state), derivative @ velocity, atol=1e-7
        )


def test_each_actuator_drives_its_joint(any_robot: Robot) -> None:
    model = scene_of(any_robot)
    state_map, data = StateMap(any_robot, model), mujoco.MjData(model)
    for index, name in enumerate(any_robot.joint_names):
        data.ctrl[:] = 0
        data.ctrl[state_map.actuators[index]] = 1.0
        mujoco.mj_forward(model, data)
        expected = np.zeros(model.nv)
        expected[model.joint(name).dofadr[0]] = 1.0
        np.testing.assert_array_equal(data.qfrc_actuator, expected)


def _legs_and_motors_swapped(text: str) -> str:
    left = re.search(r'      <body name="L_hip_flexion".*?\n      </body>\n', text, re.S)
    right = re.search(r'      <body name="R_hip_flexion".*?\n      </body>\n', text, re.S)
    assert left is not None
    assert right is not None
    text = text.replace(left[0], "@").replace(right[0], left[0]).replace("@", right[0])
    motors = re.findall(r"    <motor .*\n", text)
    return text.replace("".join(motors), "".join(reversed(motors)))


def test_joints_and_motors_are_found_by_name_not_by_order(edit_scene: EditScene) -> None:
    robot = edit_scene(_legs_and_motors_swapped)
    model = scene_of(robot)
    names = [model.joint(index).name for index in range(1, model.njnt)]
    assert names != robot.joint_names
    state_map, data = StateMap(robot, model), mujoco.MjData(model)
    (state,) = random_states(robot)[:1]
    state_map.write(data, state)
    for index, name in enumerate(robot.joint_names):
        assert data.joint(name).qpos[0] == state.q[7 + index]
        assert data.joint(name).qvel[0] == state.v[6 + index]
        assert model.actuator(int(state_map.actuators[index])).name == name
    np.testing.assert_array_equal(state_map.read(data).q, state.q)
    T = state_map.velocity_transform(state)
    np.testing.assert_allclose(T @ data.qvel, state.v, atol=1e-12)


def _without_joint(text: str) -> str:
    text = re.sub(r'\s*<joint name="L_KFE".*', "", text)
    return re.sub(r'\s*<motor name="L_KFE".*', "", text)


REFUSED: dict[str, tuple[Callable[[str], str], str]] = {
    "a joint is missing": (_without_joint, "joint L_KFE': is missing"),
    "a joint has another name": (
        lambda text: text.replace('"L_KFE"', '"L_KNEE"'),
        "joint L_KFE': is missing",
    ),
    "a motor is missing": (
        lambda text: re.sub(r'\s*<motor name="R_AFE".*', "", text),
        "actuator of joint R_AFE': there are 0",
    ),
    "a joint has two motors": (
        lambda text: text.replace("</actuator>", '<motor joint="R_AFE"/></actuator>'),
        "actuator of joint R_AFE': there are 2",
    ),
    "the base is fixed": (
        lambda text: text.replace('<freejoint name="base"/>', ""),
        "freejoint': there are 0",
    ),
    "there is another free body": (
        lambda text: text.replace(
            "</worldbody>",
            '<body pos="3 0 1"><freejoint/><geom type="sphere" size="0.1"/></body></worldbody>',
        ),
        "freejoint': there are 2",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_scene_that_lacks_something_is_refused_by_name(edit_scene: EditScene, case: str) -> None:
    change, message = REFUSED[case]
    robot = edit_scene(change)
    with pytest.raises(RobotFileError, match=re.escape(message)) as caught:
        StateMap(robot, scene_of(robot))
    assert caught.value.path == robot.scene_path


@pytest.mark.parametrize(
    "actuator",
    [
        '<position name="R_AFE" joint="R_AFE" kp="100"/>',
        '<velocity name="R_AFE" joint="R_AFE" kv="10"/>',
        '<motor name="R_AFE" joint="R_AFE" gear="2"/>',
        '<motor name="R_AFE" joint="R_AFE" gear="-1"/>',
        '<general name="R_AFE" joint="R_AFE" dyntype="filter" dynprm="0.1"/>',
    ],
)
def test_an_actuator_that_does_not_apply_its_control_as_torque_is_refused(
    edit_scene: EditScene, actuator: str
) -> None:
    robot = edit_scene(lambda text: re.sub(r'<motor name="R_AFE".*', actuator, text))
    with pytest.raises(RobotFileError, match="R_AFE"):
        StateMap(robot, scene_of(robot))


def test_a_joint_too_many_is_refused_by_name(edit_scene: EditScene) -> None:
    extra = '<body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="tail"/></body>'
    robot = edit_scene(
        lambda text: text.replace('<body name="torso_yaw"', f'{extra}<body name="torso_yaw"')
    )
    with pytest.raises(RobotFileError, match="tail"):
        StateMap(robot, scene_of(robot))
