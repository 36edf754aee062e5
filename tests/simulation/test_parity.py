from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import hypothesis
import mujoco
import numpy as np
import pytest
from hypothesis import strategies as st
from pinocchio import SE3

from tsd_casadi import Robot
from tsd_casadi.exceptions import ParityError
from tsd_clients.simulator import parity
from tsd_clients.simulator.body_parity import BodyParity
from tsd_clients.simulator.build_scene import build_scene
from tsd_clients.simulator.parity import (
    check_parity,
    find_discrepancies,
    measure_parity,
    random_state,
)
from tsd_clients.simulator.rounding import TOLERANCE
from tsd_clients.simulator.scene import load_scene
from tsd_clients.simulator.state_map import StateMap


@pytest.fixture
def scene(robot: Robot) -> Any:
    """A fresh ``mujoco.MjModel`` to be spoilt."""
    return mujoco.MjModel.from_xml_path(str(robot.scene_path))


def test_urdf_and_scene_agree_at_100_random_states(any_robot: Robot) -> None:
    model = load_scene(any_robot)
    measured = measure_parity(any_robot, model, states=100, seed=1)
    for quantity, difference in vars(measured).items():
        assert 0 <= difference <= 1e-9, quantity
    check_parity(any_robot, model)


def test_the_measure_is_not_blind(robot: Robot, scene: Any) -> None:
    # numbers of some size are compared, so 1e-9 says something
    assert measure_parity(robot, scene).mass_matrix > 0
    scene.body("torso").mass[:] += 0.5
    measured = measure_parity(robot, scene)
    assert 0.4 < measured.mass_matrix < 5
    assert measured.bias_forces > 0.5 * 9
    assert measured.center_of_mass > 1e-4


# the parts of a scene, one by one: how it is spoilt by a factor, and what is named


def _mass(model: Any, part: float) -> None:
    model.body("L_shank").mass[:] *= 1 + part


def _inertia(model: Any, part: float) -> None:
    model.body("L_shank").inertia[0] *= 1 + part


def _turned_inertia(model: Any, part: float) -> None:
    model.body_sameframe[:] = 0  # MuJoCo would not look at what is zero in its file
    mujoco.mju_axisAngle2Quat(model.body("torso").iquat, np.array([0.0, 1.0, 0.0]), 2.28 * part)


def _center_of_mass(model: Any, part: float) -> None:
    model.body("L_shank").ipos[0] += HEIGHT * part


def _placement(model: Any, part: float) -> None:
    model.body("L_shank").pos[2] -= HEIGHT * part


def _turned(model: Any, part: float) -> None:
    mujoco.mju_axisAngle2Quat(model.body("L_shank").quat, np.array([1.0, 0.0, 0.0]), part)


def _axis(model: Any, part: float) -> None:
    model.joint("L_KFE").axis[:] = (0.0, np.cos(part), np.sin(part))


def _anchor(model: Any, part: float) -> None:
    model.joint("L_KFE").pos[0] += HEIGHT * part


def _armature(model: Any, part: float) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    joint = int(model.joint("L_AAA").dofadr[0])
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    model.dof_armature[joint] = M[joint, joint] * part


def _range(model: Any, part: float) -> None:
    model.joint("L_KFE").range[1] += 2.4 * part


def _control_range(model: Any, part: float) -> None:
    model.actuator("L_KFE").ctrlrange[0] = -350 * (1 - part)


def _gravity(model: Any, part: float) -> None:
    model.opt.gravity[2] *= 1 + part


def _friction(model: Any, part: float) -> None:
    model.geom_friction[:, 0] = 0.5 * (1 - part)


HEIGHT = 0.78144  # m, of the centre of mass at home: lengths are compared with it
Spoil = Callable[[Any, float], None]
ROUNDED: dict[str, tuple[Spoil, str, str]] = {
    "mass": (_mass, "body L_shank", "mass"),
    "inertia": (_inertia, "body L_shank", "ixx about its centre of mass"),
    "inertia's axes": (_turned_inertia, "body torso", "ixz about its centre of mass"),
    "centre of mass": (_center_of_mass, "body L_shank", "centre of mass"),
    "placement": (_placement, "body L_shank", "placement on its parent"),
    "turned": (_turned, "body L_shank", "placement on its parent"),
    "axis": (_axis, "joint L_KFE", "axis"),
    "anchor": (_anchor, "joint L_KFE", "place of its axis"),
    "armature": (_armature, "joint L_AAA", "armature"),
    "range": (_range, "joint L_KFE", "range"),
    "control range": (_control_range, "motor of joint L_KFE", "control range"),
    "gravity": (_gravity, "option", "gravity"),
}


@pytest.mark.parametrize("what", ROUNDED)
def test_more_than_rounding_is_refused_by_name_and_nothing_else_is(
    robot: Robot, scene: Any, what: str
) -> None:
    spoil, element, quantity = ROUNDED[what]
    spoil(scene, 1.3 * TOLERANCE)
    found = find_discrepancies(robot, scene)
    assert [(each.element, each.quantity) for each in found] == [(element, quantity)]


@pytest.mark.parametrize("what", ROUNDED)
def test_less_than_rounding_is_the_same_robot(robot: Robot, scene: Any, what: str) -> None:
    ROUNDED[what][0](scene, 0.7 * TOLERANCE)
    check_parity(robot, scene)


def test_the_length_that_others_are_compared_with_is_the_robots(robot: Robot) -> None:
    assert robot.home_com[2] == pytest.approx(HEIGHT, rel=1e-3)


def test_six_digits_pass_and_a_mass_wrong_by_a_thousandth_does_not(any_robot: Robot) -> None:
    path = any_robot.scene_path
    spec = build_scene(any_robot) if path is None else mujoco.MjSpec.from_file(str(path))
    spec.compile()
    rounded = mujoco.MjModel.from_xml_string(spec.to_xml())
    assert max(vars(measure_parity(any_robot, rounded)).values()) > 1e-9
    check_parity(any_robot, rounded)
    rounded.body_mass[-1] *= 1.001
    with pytest.raises(ParityError, match=r"in one way:\n  body .*: mass is") as caught:
        check_parity(any_robot, rounded)
    assert caught.value.path == (path or any_robot.path)


@hypothesis.given(st.integers(0, 10_000))
def test_numbers_off_by_a_hundred_thousandth_each_pass(any_robot: Robot, seed: int) -> None:
    model = load_scene(any_robot)
    rng = np.random.default_rng(seed)
    for numbers in (
        model.body_mass,
        model.body_inertia,
        model.body_pos,
        model.body_ipos,
        model.jnt_range,
        model.actuator_ctrlrange,
    ):
        numbers[:] *= 1 + rng.uniform(-1e-5, 1e-5, size=numbers.shape)
    check_parity(any_robot, model)


def test_both_numbers_and_the_remedy_are_told(robot: Robot, scene: Any) -> None:
    _mass(scene, 1e-3)
    (found,) = find_discrepancies(robot, scene)
    assert (found.found, found.expected) == ("2.757755 kg", "2.755 kg")
    assert 'set mass="2.755"' in found.remedy


def test_everything_that_differs_is_told_at_once(robot: Robot, scene: Any) -> None:
    for spoil, _, _ in ROUNDED.values():
        spoil(scene, 1e-2)
    with pytest.raises(ParityError) as caught:
        check_parity(robot, scene)
    named = {each.element for each in caught.value.discrepancies or ()}
    assert named >= {"body L_shank", "body torso", "joint L_KFE", "joint L_AAA", "option"}
    assert str(caught.value).count("\n") == len(caught.value.discrepancies or ())


def test_a_turned_body_is_named_without_what_hangs_on_it(robot: Robot, scene: Any) -> None:
    quaternion = np.empty(4)
    mujoco.mju_axisAngle2Quat(quaternion, np.array([0.6, 0.8, 0.0]), 0.2)
    scene.body("L_thigh").quat[:] = quaternion
    (found,) = find_discrepancies(robot, scene)
    assert (found.element, found.quantity) == ("body L_thigh", "placement on its parent")
    assert "turned" in found.remedy


def test_two_misplaced_bodies_of_a_leg_are_both_named(robot: Robot, scene: Any) -> None:
    scene.body("L_thigh").pos[0] += 0.01
    scene.body("L_foot").pos[1] += 0.01
    found = find_discrepancies(robot, scene)
    assert [each.element for each in found] == ["body L_thigh", "body L_foot"]


# what passive forces there are


PASSIVE: dict[str, tuple[Callable[[Any], None], str, str]] = {
    "damping": (
        lambda model: model.joint("L_KFE").damping.__setitem__(0, 0.1),
        "joint L_KFE",
        "damping",
    ),
    "stiffness": (
        lambda model: model.joint("B_TR").stiffness.__setitem__(0, 2.0),
        "joint B_TR",
        "stiffness",
    ),
    "friction loss": (
        lambda model: model.joint("R_AFE").frictionloss.__setitem__(0, 0.01),
        "joint R_AFE",
        "friction loss",
    ),
    "of the base": (lambda model: model.dof_damping.__setitem__(2, 1.0), "joint base", "damping"),
    "gravity compensation": (
        lambda model: model.body_gravcomp.__setitem__(1, 1.0),
        "body pelvis",
        "gravity compensation",
    ),
    "fluid": (lambda model: setattr(model.opt, "density", 1.2), "medium", "density"),
    "viscosity": (lambda model: setattr(model.opt, "viscosity", 1e-5), "medium", "viscosity"),
    "no contacts": (
        lambda model: setattr(model.opt, "disableflags", mujoco.mjtDisableBit.mjDSBL_CONTACT),
        "option",
        "flag contact",
    ),
}


@pytest.mark.parametrize("what", PASSIVE)
def test_passive_forces_are_named(robot: Robot, scene: Any, what: str) -> None:
    spoil, element, quantity = PASSIVE[what]
    spoil(scene)
    (found,) = find_discrepancies(robot, scene)
    assert (found.element, found.quantity) == (element, quantity)


def _edited(robot: Robot, *replacements: tuple[str, str], count: int = 1) -> Any:
    """The robot's scene with some of its text replaced."""
    body = (robot.path.parent / "hermes_lower.xml").read_text()
    text = robot.scene_path.read_text().replace('<include file="hermes_lower.xml"/>', "")
    text = text.replace("</mujoco>", body[body.index("<mujoco") :].split("\n", 1)[1])
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new, count)
    return mujoco.MjModel.from_xml_string(text)


EDITED: dict[str, tuple[str, str, str, str]] = {
    "force range": (
        '<motor name="L_KFE" joint="L_KFE" ctrlrange="-350 350"/>',
        '<motor name="L_KFE" joint="L_KFE" forcerange="-300 300"/>',
        "motor of joint L_KFE",
        "force range",
    ),
    "force range of a joint": (
        '<joint name="L_KFE"',
        '<joint name="L_KFE" actuatorfrcrange="-340 340"',
        "joint L_KFE",
        "actuator force range",
    ),
    "no joint range": (' range="0 2.4"/>', "/>", "joint L_KFE", "range"),
    "equality": (
        "<actuator>",
        '<equality><joint name="knees" joint1="L_KFE" joint2="R_KFE"/></equality><actuator>',
        "equality knees",
        "state",
    ),
    "tendon": (
        "<actuator>",
        '<tendon><fixed name="strap" stiffness="3"><joint joint="L_KFE" coef="1"/></fixed></tendon>'
        "<actuator>",
        "tendon strap",
        "stiffness",
    ),
    "no floor": ('type="plane"', 'type="plane" contype="0" conaffinity="0"', "world", "the floor"),
    "a low floor": ('type="plane"', 'type="plane" pos="0 0 -0.01"', "geom floor", "the floor"),
    "a sloped floor": (
        'type="plane"',
        'type="plane" euler="0.01 0 0"',
        "geom floor",
        "the floor",
    ),
    "a box that is too high": (
        'type="plane" size="4 4 0.1"',
        'type="box" size="4 4 0.1" pos="0 0 -0.08"',
        "geom floor",
        "the floor",
    ),
    "no foot": (
        '<geom name="L_foot" class="foot"',
        '<geom name="L_foot" class="visual" type="box"',
        "contact left_foot",
        "the foot",
    ),
    "a foot that the floor does not see": (
        "<actuator>",
        '<contact><exclude body1="world" body2="R_foot"/></contact><actuator>',
        "contact right_foot",
        "the foot",
    ),
    "a foot too high": (
        'class="foot" pos="0.04 0 -0.044"',
        'class="foot" pos="0.04 0 -0.034"',
        "contact left_foot",
        "the underside of the foot",
    ),
    "a foot too low": (
        'class="foot" pos="0.04 0 -0.044"',
        'class="foot" pos="0.04 0 -0.054"',
        "contact left_foot",
        "the underside of the foot",
    ),
    "a sole too short": (
        'size="0.125 0.06 0.02"',
        'size="0.09 0.06 0.02"',
        "contact left_foot",
        "the sole in its frame",
    ),
    "a round foot": (
        'size="0.125 0.06 0.02"',
        'type="sphere" size="0.02"',
        "contact left_foot",
        "the sole in its frame",
    ),
}


@pytest.mark.parametrize("what", EDITED)
def test_what_a_scene_gets_wrong_is_named(robot: Robot, what: str) -> None:
    old, new, element, quantity = EDITED[what]
    (found,) = find_discrepancies(robot, _edited(robot, (old, new)))
    assert (found.element, found.quantity) == (element, quantity)
    assert found.remedy


def test_a_sole_one_centimetre_off_is_told_in_millimetres(robot: Robot) -> None:
    old, new, *_ = EDITED["a foot too high"]
    (found,) = find_discrepancies(robot, _edited(robot, (old, new)))
    assert found.found == "10.0 mm above frame L_sole"


@pytest.mark.parametrize(("off", "wrong"), [(0.0009, False), (0.0011, True)])
def test_a_sole_may_be_off_by_as_much_as_home_may_leave_it(
    robot: Robot, scene: Any, off: float, wrong: bool
) -> None:
    scene.geom("L_foot").pos[2] += off
    assert bool(find_discrepancies(robot, scene)) == wrong


@pytest.mark.parametrize(("half", "wrong"), [(0.0991, False), (0.0989, True)])
def test_a_sole_may_be_smaller_by_as_much(
    robot: Robot, scene: Any, half: float, wrong: bool
) -> None:
    scene.geom("L_foot").size[0] = half
    scene.geom("L_foot").pos[0] = 0.04
    assert bool(find_discrepancies(robot, scene)) == wrong


@pytest.mark.parametrize(("part", "wrong"), [(0.7e-4, False), (1.3e-4, True)])
def test_friction_below_what_the_controller_counts_on_is_named_for_each_foot(
    robot: Robot, scene: Any, part: float, wrong: bool
) -> None:
    _friction(scene, part)
    found = [each.element for each in find_discrepancies(robot, scene)]
    assert found == (["contact left_foot", "contact right_foot"] if wrong else [])


def test_friction_is_mujocos_own_of_both_geoms(robot: Robot, scene: Any) -> None:
    # the larger of both counts, unless one has priority
    scene.geom("floor").friction[0] = 0.1
    check_parity(robot, scene)
    scene.geom("floor").priority[:] = 1
    assert len(find_discrepancies(robot, scene)) == 2
    data = mujoco.MjData(scene)
    StateMap(robot, scene).write(data, robot.home)
    data.qpos[2] -= 1e-4
    mujoco.mj_forward(scene, data)
    assert {contact.friction[0] for contact in data.contact} == {0.1}


def test_friction_of_a_pair_counts_before_that_of_its_geoms(robot: Robot) -> None:
    pairs = "".join(
        f'<pair geom1="floor" geom2="{side}_foot" friction="0.3 0.3 0.02 0.0001 0.0001"/>'
        for side in "LR"
    )
    model = _edited(robot, ("<actuator>", f"<contact>{pairs}</contact><actuator>"))
    found = find_discrepancies(robot, model)
    assert [each.found for each in found] == ["0.3", "0.3"]


@pytest.mark.parametrize(
    "shape",
    [
        'type="capsule" fromto="-0.12 {y} 0.01 0.12 {y} 0.01" size="0.01"',
        'type="cylinder" pos="0 {y} 0.01" euler="0 1.5707963 0" size="0.01 0.12"',
        'type="mesh" mesh="plate" pos="0 {y} 0.01"',
    ],
)
def test_feet_of_any_shape_are_measured(robot: Robot, shape: str) -> None:
    def foot(y: float) -> str:
        return f'<geom {shape.format(y=y)} friction="0.8" mass="0"/>'

    old = '<geom name="L_foot" class="foot" pos="0.04 0 -0.044" size="0.125 0.06 0.02"/>'
    new = f'<body pos="0.04 0 -0.064">{foot(-0.055)}{foot(0.055)}</body>'
    corners = product(*((-half, half) for half in (0.12, 0.01, 0.01)))
    vertices = " ".join(str(x) for corner in corners for x in corner)
    mesh = f'<asset><mesh name="plate" vertex="{vertices}"/></asset><actuator>'
    assert find_discrepancies(robot, _edited(robot, (old, new), ("<actuator>", mesh))) == []


def test_a_box_does_for_a_floor_and_obstacles_beside_it_do_not_matter(robot: Robot) -> None:
    box = 'type="box" size="4 4 0.1" pos="0 0 -0.1"'
    wall = '<geom type="box" size="0.1 2 1" pos="3 0 1"/><light pos'
    model = _edited(robot, ('type="plane" size="4 4 0.1"', box), ("<light pos", wall))
    assert find_discrepancies(robot, model) == []


def test_what_overlaps_at_home_is_named(robot: Robot) -> None:
    sphere = '<geom type="sphere" size="0.06"/>'
    visual = '<geom class="visual" type="sphere" size="0.06"/>'
    # both hip joints get spheres of 0.12 m, 0.2 m apart
    model = _edited(robot, (visual, sphere.replace("0.06", "0.12")), count=99)
    found = [each for each in find_discrepancies(robot, model) if "overlap" in each.quantity]
    assert "bodies L_hip_flexion and R_hip_flexion" in {each.element for each in found}


def test_what_no_part_explains_is_still_refused(
    robot: Robot, scene: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    _mass(scene, 0.5)
    monkeypatch.setattr(parity, "compare_bodies", lambda *_: BodyParity([], [SE3.Identity()] * 99))
    (first, *_) = find_discrepancies(robot, scene)
    assert (first.element, first.quantity) == ("whole robot", "mass matrix")


def test_looks_are_no_part_of_parity(robot: Robot, scene: Any) -> None:
    scene.geom_size[scene.geom_group == 2] *= 2
    scene.geom_rgba[:] = 0
    check_parity(robot, scene)


def test_more_states_never_look_better(robot: Robot, scene: Any) -> None:
    _mass(scene, 1e-6)
    few, many = (vars(measure_parity(robot, scene, states=n)) for n in (2, 20))
    assert all(many[name] >= few[name] for name in few)


def test_random_states_are_within_limits_and_nowhere_zero(robot: Robot) -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        state = random_state(robot, rng)
        assert np.linalg.norm(state.q[3:7]) == pytest.approx(1.0)
        assert np.all(state.q[7:] >= robot.model.lowerPositionLimit[7:])
        assert np.all(state.q[7:] <= robot.model.upperPositionLimit[7:])
        assert np.abs(state.q).min() > 0
        assert np.abs(state.v).min() > 0


def test_measuring_twice_gives_the_same(robot: Robot, scene: Any) -> None:
    assert measure_parity(robot, scene, seed=3) == measure_parity(robot, scene, seed=3)
