"""Descriptions with one thing wrong: what is proposed, or which link and joint is named."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.motions.catalogue import shipped_motions
from tsd_casadi.motions.motion import declared_parameters
from tsd_casadi.motions.ranges import range_of
from tsd_casadi.proposal.masses import heavy_links
from tsd_casadi.proposal.motion_ranges import MOTIONS
from tsd_casadi.proposal.motions_text import motions_text
from tsd_casadi.proposal.propose import Proposal, propose_robot_file
from tsd_casadi.proposal.survey import survey
from tsd_casadi.robot.robot import Robot

FEET = ("left_foot", "right_foot")
Write = Callable[..., Path]


def propose(path: Path, *locks: str, feet: tuple[str, str] = FEET) -> tuple[Proposal, Robot]:
    robot_file = path.parent / "small.yaml"
    proposal = propose_robot_file(path, feet, locks, "small", robot_file)
    robot_file.write_text(proposal.text)
    return proposal, Robot(robot_file)


def changed(path: Path, *changes: tuple[str, str]) -> Path:
    """Write other words into a description, each where it is first."""
    text = path.read_text()
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    path.write_text(text)
    return path


HAND_MASS = '<link name="left_hand"><inertial><origin xyz="0 0 -0.1"/><mass value="1.0"/>'
FOOT_MASS = '<link name="left_foot"><inertial><origin xyz="0 0 -0.02"/><mass value="0.8"/>'
SHANK_MASS = '<link name="left_knee_link"><inertial><origin xyz="0 0 -0.02"/><mass value="2.0"/>'
SENSOR = (
    '<link name="camera"><inertial><mass value="{}"/><inertia ixx="1e-5" iyy="1e-5" izz="1e-5" '
    'ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="mount2" type="fixed">'
    '<parent link="{}"/><child link="camera"/></joint>'
)


@pytest.mark.parametrize("mass", ["-0.51", "nan", "inf", "-1e-9", "1,5"])
@pytest.mark.parametrize("parent", ["chest", "left_foot"])
def test_a_mass_that_is_none_is_refused_by_link(
    small_humanoid: Write, mass: str, parent: str
) -> None:
    """Of a link that is fixed to a heavier one too."""
    with pytest.raises(RobotFileError, match=r"link camera.*its mass.*kg") as caught:
        propose(small_humanoid(extra=SENSOR.format(mass, parent)))
    assert caught.value.path is not None
    assert caught.value.path.name == "small.urdf"


def test_a_foot_without_mass_is_refused_by_link(small_humanoid: Write) -> None:
    path = changed(small_humanoid(), (FOOT_MASS, FOOT_MASS.replace("0.8", "0")))
    with pytest.raises(RobotFileError, match=r"link left_foot.*has no mass, and joint left_ankle"):
        propose(path)


def test_an_inertia_without_mass_between_two_axes_is_replaced(small_humanoid: Write) -> None:
    """As those that carry the axes of one joint after the other are often written."""
    yaw = '<link name="left_hip_yaw_link"><inertial><origin xyz="0 0 -0.02"/><mass value="0.6"/>'
    proposal, robot = propose(changed(small_humanoid(), (yaw, yaw.replace("0.6", "0"))))
    assert robot.description.links["left_hip_yaw_link"].inertia == (0.0,) * 6
    assert any("left_hip_yaw_link" in note for note in proposal.notes)


def test_a_hand_without_mass_is_locked(small_humanoid: Write) -> None:
    proposal, robot = propose(changed(small_humanoid(), (HAND_MASS, HAND_MASS.replace("1.0", "0"))))
    assert "left_elbow" in robot.description.locked
    assert any("nothing that has a mass: left_elbow" in note for note in proposal.notes)


def test_grams_are_told_even_where_they_leave_no_posture(small_humanoid: Write) -> None:
    path = changed(small_humanoid(), (SHANK_MASS, SHANK_MASS.replace("2.0", "2000")))
    with pytest.raises(RobotFileError, match=r"link left_knee_link has 2000 kg, 98 %.*in grams"):
        propose(path)


@pytest.mark.parametrize(("shares", "told"), [(0.49, False), (0.51, True)])
def test_a_link_of_half_the_robot_is_told(small_humanoid: Write, shares: float, told: bool) -> None:
    proposal, _ = propose(small_humanoid())
    others = proposal.survey.body.mass - 1.0
    heavy = f"{others * shares / (1 - shares):.6g}"
    path = changed(small_humanoid(), (HAND_MASS, HAND_MASS.replace("1.0", heavy)))
    notes = heavy_links(survey(path, FEET, ()).bodies)
    assert any("link left_hand" in note for note in notes) == told
    assert not any("grams" in note for note in notes)


@pytest.mark.parametrize(("total", "told"), [(499.0, False), (501.0, True)])
def test_a_robot_of_half_a_ton_is_told(small_humanoid: Write, total: float, told: bool) -> None:
    """By its heaviest link, none of which has half of it."""
    path = small_humanoid()
    factor = total / survey(path, FEET, ()).body.mass
    heavier = re.sub(
        r'mass value="([^"]+)"', lambda m: f'mass value="{factor * float(m[1])}"', path.read_text()
    )
    path.write_text(heavier)
    suspicions = survey(path, FEET, ()).suspicions
    assert any("link is chest" in each and "in grams?" in each for each in suspicions) == told


def test_a_mesh_of_a_foot_that_is_missing_is_named(small_humanoid: Write) -> None:
    box = '<origin xyz="0.03 0 -0.045"/><geometry><box size="0.2 0.08 0.03"/></geometry>'
    drawn = box.replace("0.08", "0.07")
    both = f"<visual>{drawn}</visual><collision>{box}</collision>"
    mesh = '<collision><geometry><mesh filename="sole.stl"/></geometry></collision>'
    path = small_humanoid(both)
    changed(path, (f"<collision>{box}</collision>", mesh))
    notes = survey(path, FEET, ()).notes
    assert any("NOT THERE: sole.stl" in note for note in notes)
    assert any("soles differ by 10 mm" in note for note in notes)


@pytest.mark.parametrize(("width", "told"), [("0.0825", False), ("0.0835", True)])
def test_soles_that_differ_are_told(small_humanoid: Write, width: str, told: bool) -> None:
    path = changed(small_humanoid(), ("0.2 0.08 0.03", f"0.2 {width} 0.03"))
    assert any("soles differ" in note for note in survey(path, FEET, ()).notes) == told


def test_the_patch_and_what_counts_of_it_are_told(small_humanoid: Write) -> None:
    notes = survey(small_humanoid(), FEET, ()).notes
    (left,) = [note for note in notes if note.startswith("left sole")]
    assert "200 mm x 80 mm" in left
    assert "0.9 of it, 180 mm x 72 mm" in left


@pytest.mark.parametrize(
    ("ahead", "suspected", "certain"),
    [(-0.008, False, False), (-0.01, True, False), (-0.019, True, False), (-0.021, False, True)],
)
def test_long_heels_are_asked_about_and_longer_ones_are_a_problem(
    small_humanoid: Write, ahead: float, suspected: bool, certain: bool
) -> None:
    """Of a sole of 200 mm; 1.2 and 1.5 times the toes are 9.1 mm and 20 mm behind the ankle."""
    foot = f'<collision><origin xyz="{ahead} 0 -0.045"/><geometry><box size="0.2 0.08 0.03"/>'
    found = survey(small_humanoid(foot + "</geometry></collision>"), FEET, ())
    assert any("is LEFT really" in each for each in found.suspicions) == suspected
    assert any("is LEFT really" in each for each in found.mistakes) == certain


def test_motions_without_room_get_the_smallest_range(small_humanoid: Write) -> None:
    """Left out, they would get the ranges that inverse kinematics alone reaches."""
    text = "\n".join(motions_text({"sway": {"amplitude": (0.001, 0.05)}}))
    ranges = yaml.safe_load(text)["motions"]
    assert ranges["sway"] == {"amplitude": [0.001, 0.05]}
    assert ranges["squat"] == ranges["twist"] == {"amplitude": [0.0, 0.001]}
    proposal, _ = propose(small_humanoid())
    robot_file = small_humanoid().parent / "small.yaml"
    head = proposal.text[: proposal.text.index("# Over these ranges")]
    robot_file.write_text(head + "\n".join(motions_text({})))
    robot = Robot(robot_file)
    for name in MOTIONS:
        kind = shipped_motions()[name]
        (amplitude,) = [p for p in declared_parameters(kind) if p.name == "amplitude"]
        assert range_of(robot, kind, amplitude) == (0.0, 0.001)


def test_a_robot_without_room_has_a_problem(small_humanoid: Write) -> None:
    """Knees that hardly bend: home is there, nothing around it."""
    proposal, robot = propose(small_humanoid(limits={"knee": "0 0.9"}))
    assert not proposal.ranges
    assert set(robot.description.motions) == set(MOTIONS)
    assert "no room for any motion" in proposal.problems[-1]


def test_hands_are_no_feet(small_humanoid: Write) -> None:
    path = small_humanoid()
    feet = ("left_hand", "right_hand")
    with pytest.raises(RobotFileError, match=r"arms.*--feet left_foot,right_foot"):
        propose(path, feet=feet)
    with pytest.raises(RobotFileError, match=r"--feet right_foot,left_foot"):
        propose(path, feet=(feet[1], feet[0]))  # a robot that faces backwards


def test_for_a_wrong_foot_the_ends_of_the_legs_are_named(small_humanoid: Write) -> None:
    with pytest.raises(RobotFileError, match=r"legs seem to end in left_foot and right_foot"):
        propose(small_humanoid(), feet=("l_sole", "r_sole"))


ELBOW_LIMIT = 'lower="-2.2" upper="0" effort="30"'


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (ELBOW_LIMIT, 'effort="30"', "has no limits"),
        (ELBOW_LIMIT, 'lower="1" upper="-1" effort="30"', "has limits from 1 to -1 rad"),
        (ELBOW_LIMIT, 'lower="a" upper="1" effort="30"', "has limits from nan"),
        ('name="left_elbow" type="revolute"', 'name="left_elbow" type="planar"', "type 'planar'"),
    ],
)
def test_a_joint_that_cannot_be_used_is_told_with_options_of_new(
    small_humanoid: Write, old: str, new: str, told: str
) -> None:
    with pytest.raises(RobotFileError, match=r"joint left_elbow") as caught:
        propose(changed(small_humanoid(), (old, new)))
    assert told in str(caught.value)
    assert "--lock left_elbow" in str(caught.value)
    assert "yaml" not in str(caught.value)


def test_locked_it_needs_no_limits(small_humanoid: Write) -> None:
    path = changed(small_humanoid(), (ELBOW_LIMIT, 'effort="30"'))
    _, robot = propose(path, "left_elbow")
    assert "left_elbow" not in robot.joint_names


@pytest.mark.parametrize("limit", ['lower="-2.2" upper="0"'])
def test_a_missing_torque_limit_is_assumed_and_told(small_humanoid: Write, limit: str) -> None:
    knee = 'lower="0.0" upper="2.4" effort="150"'
    path = changed(
        small_humanoid(), (ELBOW_LIMIT, limit), (knee, knee.removesuffix(' effort="150"'))
    )
    proposal, robot = propose(path)
    assert set(robot.description.effort) == {"left_elbow", "left_knee"}
    assert any("2 joints are ASSUMED" in n and "left_knee" in n for n in proposal.notes)


def test_a_knee_that_mimics_and_an_axis_that_is_none_are_told_by_joint(
    small_humanoid: Write,
) -> None:
    knee = re.compile(r'(<joint name="left_knee".*?)<axis xyz="0 1 0"/>(.*?)</joint>')
    text = small_humanoid().read_text()
    path = small_humanoid()
    path.write_text(knee.sub(r'\1<axis xyz="0 0 0"/>\2</joint>', text))
    with pytest.raises(RobotFileError, match=r"joint left_knee.*axis 0 0 0"):
        propose(path)
    mimic = r'\1<axis xyz="0 1 0"/>\2<mimic joint="left_hip_pitch"/></joint>'
    path.write_text(knee.sub(mimic, text))
    with pytest.raises(RobotFileError, match=r"joint left_knee.*mimics left_hip_pitch, in a leg"):
        propose(path)


@pytest.mark.parametrize(("high", "told"), [("6.28", False), ("6.29", True), ("90", True)])
def test_limits_beyond_a_turn_look_like_degrees(
    small_humanoid: Write, high: str, told: bool
) -> None:
    path = changed(small_humanoid(), (ELBOW_LIMIT, ELBOW_LIMIT.replace('"0"', f'"{high}"')))
    suspicions = survey(path, FEET, ()).suspicions
    assert any("degrees" in each and "left_elbow" in each for each in suspicions) == told


def test_a_velocity_limit_of_zero_is_told(small_humanoid: Write) -> None:
    path = small_humanoid()
    elbow = re.search(ELBOW_LIMIT + r' velocity="[^"]*"', path.read_text())
    assert elbow is not None
    changed(path, (elbow[0], ELBOW_LIMIT + ' velocity="0"'))
    (note,) = survey(path, FEET, ()).suspicions
    assert "velocity limits of 0" in note
    assert "left_elbow" in note
