"""Robot files from a description and two feet: they load, and say what was done."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from tsd_casadi.exceptions import InvalidValue, RobotFileError, TsdError
from tsd_casadi.motions.catalogue import shipped_motions
from tsd_casadi.proposal.data_package import find_in_package
from tsd_casadi.proposal.gains import HEIGHT, MASS, scale_gains
from tsd_casadi.proposal.posed import LEAST_BEND, LEAST_MARGIN, SAG
from tsd_casadi.proposal.propose import Proposal, name_for, propose_robot_file
from tsd_casadi.proposal.source_path import path_in_file
from tsd_casadi.proposal.yaml_text import key_text
from tsd_casadi.robot.description_path import find_package
from tsd_casadi.robot.reaching import reach
from tsd_casadi.robot.robot import Robot

FEET = ("left_foot", "right_foot")
Write = Callable[..., Path]
needs_data = pytest.mark.skipif(
    find_package("example-robot-data") is None, reason="example-robot-data is not installed"
)


def propose(path: Path, *locks: str, feet: tuple[str, str] = FEET) -> tuple[Proposal, Robot]:
    robot_file = path.parent / "small.yaml"
    proposal = propose_robot_file(path, feet, locks, "small", robot_file)
    robot_file.write_text(proposal.text)
    return proposal, Robot(robot_file)


def finger(
    name: str, parent: str, more: str = "", kind: str = "revolute", effort: float = 1
) -> str:
    limit = "" if kind == "continuous" else 'lower="0.1" upper="1"'
    return (
        f'<link name="{name}_link"><inertial><mass value="0.05"/><inertia ixx="1e-5" iyy="1e-5" '
        f'izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{name}_link"/>'
        f'<origin xyz="0 0 -0.1"/><axis xyz="1 0 0"/>'
        f'<limit {limit} effort="{effort}" velocity="1"/>{more}</joint>'
    )


def test_a_file_loads_as_it_is_and_names_its_parts(small_humanoid: Write) -> None:
    proposal, robot = propose(small_humanoid())
    assert robot.name == "small"
    assert [contact.name for contact in robot.description.contacts] == ["left_foot", "right_foot"]
    tasks = {task.name: task for task in robot.description.tasks}
    assert list(tasks) == ["com", "pelvis", "torso"]
    assert tasks["torso"].axes == ("rz",)  # the waist turns about nothing else
    assert set(robot.description.motions) == set(proposal.ranges)
    assert set(proposal.ranges) <= set(shipped_motions())


def test_the_file_says_the_posture_that_was_found(small_humanoid: Write) -> None:
    proposal, robot = propose(small_humanoid())
    np.testing.assert_allclose(robot.home.q[7:], proposal.home.posed.q[7:], atol=1e-4)
    assert robot.home_com[2] == pytest.approx(proposal.home.posed.height, abs=1e-3)


def test_over_the_squat_with_its_sag_the_margins_hold(small_humanoid: Write) -> None:
    """By the robot's own inverse kinematics, which the proposal does not use."""
    proposal, robot = propose(small_humanoid())
    low, high = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
    farthest = proposal.ranges["squat"]["amplitude"][1] + SAG
    for height in (-farthest, farthest):
        posture = reach(robot, robot.home, {"com.z": height})
        assert posture is not None
        q = posture.q[7:]
        assert np.minimum(q - low, high - q).min() > LEAST_MARGIN - 5e-3
        knees = [leg.bend(robot.model, posture.q) for leg in proposal.survey.body.legs]
        assert min(knees) > LEAST_BEND - 5e-3


@pytest.mark.parametrize("rpy", ["1.5707963 0 0", "0 -1.5707963 0", "0 0 3.1415927", "0 1.0 0"])
def test_a_turned_base_is_put_upright(small_humanoid: Write, rpy: str) -> None:
    """The same robot whatever the axes of its base link are."""
    _, upright = propose(small_humanoid())
    turned_proposal, turned = propose(small_humanoid(base=rpy))
    assert any("base_orientation" in note for note in turned_proposal.notes)
    np.testing.assert_allclose(turned.home_com[2], upright.home_com[2], atol=5e-3)
    data = turned.model.createData()
    pinocchio.framesForwardKinematics(turned.model, data, turned.home.q)
    pelvis = data.oMf[turned.model.getFrameId("pelvis")].rotation
    np.testing.assert_allclose(pelvis, np.eye(3), atol=2e-3)


def test_named_joints_are_locked_next_to_zero(small_humanoid: Write) -> None:
    extra = finger("left_finger", "left_hand") + finger("right_finger", "right_hand")
    _, robot = propose(small_humanoid(extra=extra), ".*_finger")
    assert robot.description.locked == {".*_finger": 0.1}  # their limits begin there
    assert "left_finger" not in robot.joint_names


def test_fingers_are_only_mentioned(small_humanoid: Write) -> None:
    proposal, robot = propose(small_humanoid(extra=finger("left_thumb", "left_hand")))
    assert "left_thumb" in robot.joint_names
    assert any("left_thumb" in note and "--lock" in note for note in proposal.notes)


def test_a_mimic_joint_is_locked_and_told(small_humanoid: Write) -> None:
    extra = finger("left_tip", "left_hand", '<mimic joint="left_elbow" multiplier="0.5"/>')
    proposal, robot = propose(small_humanoid(extra=extra))
    assert "left_tip" in robot.description.locked
    assert any("mimic" in note and "left_tip" in note for note in proposal.notes)


def test_a_joint_without_torque_is_locked_and_told(small_humanoid: Write) -> None:
    proposal, robot = propose(small_humanoid(extra=finger("left_tip", "left_hand", effort=0)))
    assert "left_tip" in robot.description.locked
    assert any("torque limit is 0" in note and "left_tip" in note for note in proposal.notes)


def test_a_leg_without_torque_is_refused(small_humanoid: Write) -> None:
    path = small_humanoid()
    path.write_text(path.read_text().replace('effort="150"', 'effort="0"'))
    with pytest.raises(RobotFileError, match=r"left_knee.*is 0 in a leg"):
        propose(path)


def test_a_continuous_joint_gets_half_a_turn_and_is_told(small_humanoid: Write) -> None:
    extra = finger("left_wrist", "left_hand", kind="continuous")
    proposal, robot = propose(small_humanoid(extra=extra))
    assert robot.description.position == {"left_wrist": (-3.1415, 3.1415)}
    assert any("left_wrist" in note and "half a turn" in note for note in proposal.notes)


def test_an_impossible_inertia_is_replaced_and_told(small_humanoid: Write) -> None:
    path = small_humanoid()
    broken = path.read_text().replace('iyy="0.03" izz="0.024"', 'iyy="0.03" izz="0.9"')
    assert broken != path.read_text()
    path.write_text(broken)
    proposal, robot = propose(path)
    assert set(robot.description.links) == {"left_hip_pitch_link", "right_hip_pitch_link"}
    assert any("no body can have" in note for note in proposal.notes)


@pytest.mark.parametrize(
    ("feet", "locks", "told"),
    [
        (("left_fot", "right_foot"), (), "one of left_foot"),
        (("left_foot", "left_foot"), (), "one and the same body"),
        (("pelvis", "right_foot"), (), "pelvis is a part of the base"),
        (FEET, ("elbow",), "matches no joint that moves"),
        (FEET, ("(",), "is no regular expression"),
    ],
)
def test_what_is_named_wrongly_is_told(
    small_humanoid: Write, feet: tuple[str, str], locks: tuple[str, ...], told: str
) -> None:
    with pytest.raises(TsdError, match=told):
        propose(small_humanoid(), *locks, feet=feet)


def test_feet_in_the_other_order_are_told(small_humanoid: Write) -> None:
    proposal, _ = propose(small_humanoid(), feet=("right_foot", "left_foot"))
    (problem,) = proposal.problems
    assert "is LEFT really the left foot" in problem
    assert "--feet left_foot,right_foot" in problem


def test_a_description_above_the_file_is_refused(tmp_path: Path) -> None:
    below = tmp_path / "below"
    below.mkdir()
    with pytest.raises(RobotFileError, match="--out"):
        path_in_file(tmp_path / "robot.urdf", below / "robot.yaml")
    assert path_in_file(below / "robot.urdf", tmp_path / "robot.yaml") == "below/robot.urdf"


def test_gains_of_hermes_are_its_own(small_humanoid: Write) -> None:
    """Scaling is about hermes_lower: forces with the weight, moments with weight times height."""
    proposal, _ = propose(small_humanoid())
    gains = scale_gains(proposal.survey.body, proposal.home)
    mass, height = proposal.survey.body.mass / MASS, proposal.home.posed.height / HEIGHT
    assert gains.force * mass**2 == pytest.approx(1e-6, rel=0.05)
    assert gains.moment * (mass * height) ** 2 == pytest.approx(1e-5, rel=0.05)
    assert gains.minimum_force / mass == pytest.approx(5, rel=0.05)


@pytest.mark.parametrize(
    ("text", "name"), [("g1-29.dof", "g1_29_dof"), ("2legs", "robot_2legs"), ("--", "robot")]
)
def test_names_are_chunks_of_keys(text: str, name: str) -> None:
    assert name_for(text) == name


@pytest.mark.parametrize("name", ["no", "ON", "1_joint", "a: b", "left-knee", "it's", "null"])
def test_awkward_names_are_quoted(name: str) -> None:
    import yaml

    assert yaml.safe_load(f"{key_text(name)}: 1") == {name: 1}


@needs_data
def test_of_several_descriptions_the_one_without_fingers_is_taken() -> None:
    feet = ("left_ankle_roll_link", "right_ankle_roll_link")
    path, notes = find_in_package("g1", feet, ())
    assert path.name == "g1_29dof_rev_1_0.urdf"
    assert "g1_29dof_with_hand_rev_1_0.urdf" in notes[0]
    with_hands, _ = find_in_package("g1_description", feet, (".*_hand_.*",))
    assert with_hands.name == "g1_29dof_with_hand_rev_1_0.urdf"


@needs_data
def test_an_unknown_robot_or_foot_is_told_with_the_nearest() -> None:
    with pytest.raises(InvalidValue, match=r"talos"):
        find_in_package("tallos", FEET, ())
    with pytest.raises(RobotFileError, match=r"left_sole_link.*leg_left_6_link and"):
        find_in_package("talos", ("left_sole", "right_sole"), ())


@needs_data
@pytest.mark.parametrize(
    ("package", "feet", "locks"),
    [
        ("g1", ("left_ankle_roll_link", "right_ankle_roll_link"), ()),
        ("talos", ("left_sole_link", "right_sole_link"), ("gripper_.*",)),
        ("icub", ("l_sole", "r_sole"), ()),
        ("alexander", ("LEFT_FOOT", "RIGHT_FOOT"), ()),
    ],
)
def test_public_humanoids_get_files_that_load(
    package: str, feet: tuple[str, str], locks: tuple[str, ...], tmp_path: Path
) -> None:
    path, _ = find_in_package(package, feet, locks)
    robot_file = tmp_path / f"{package}.yaml"
    proposal = propose_robot_file(path, feet, locks, package, robot_file)
    robot_file.write_text(proposal.text)
    assert Robot(robot_file).n == proposal.survey.body.n
    assert proposal.ranges["squat"]["amplitude"][1] >= 0.02
    assert proposal.home.posed.bend > 1.2
