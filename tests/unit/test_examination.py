from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tsd_casadi import Controller, Robot, load_robot
from tsd_casadi.examination.examine import examine
from tsd_casadi.examination.finding import Finding
from tsd_casadi.examination.impossible_links import SLIGHT, impossible_links
from tsd_casadi.examination.motion_demands import demands_of, torque_at_rest
from tsd_casadi.examination.suspicious_numbers import suspicious_numbers
from tsd_casadi.motions.squat import Squat
from tsd_casadi.motions.sway import Sway
from tsd_casadi.robot.description import read_description

WriteRobot = Callable[..., Path]


def update(**sections: Any) -> Callable[[Any], object]:
    return lambda document: document.update(sections)


def findings_of(path: Path) -> dict[str, Finding]:
    return {finding.element: finding for finding in suspicious_numbers(load_robot(path))}


# numbers


def test_the_shipped_robot_has_no_suspicious_numbers(robot: Robot) -> None:
    assert suspicious_numbers(robot) == []


def test_one_effort_for_all_joints_is_suspicious(write_robot: WriteRobot) -> None:
    found = findings_of(write_robot(update(effort={".*": 100.0})))
    assert "100 N m for every joint" in found["effort"].found
    assert not findings_of(write_robot(update(effort={"[LR]_.*": 100.0})))


def test_a_torque_that_no_motor_has_is_suspicious(write_robot: WriteRobot, robot: Robot) -> None:
    highest = 3 * robot.weight * float(robot.home_com[2])
    found = findings_of(write_robot(update(effort={"._KFE": 1.01 * highest})))
    assert set(found) == {"joint L_KFE", "joint R_KFE"}
    assert not findings_of(write_robot(update(effort={"._KFE": 0.99 * highest})))


def test_limits_of_twins_are_equal_or_mirrored(write_robot: WriteRobot) -> None:
    found = findings_of(write_robot(update(position={"L_HAA": [-2.2, 0.8]})))
    assert set(found) == {"joint L_HAA"}
    assert "R_HAA" in found["joint L_HAA"].found
    # as rounding may have it
    robot = load_robot(write_robot())
    place = robot.model.joints[robot.model.getJointId("L_HAA")].idx_q
    low, high = (
        float(limits[place])
        for limits in (robot.model.lowerPositionLimit, robot.model.upperPositionLimit)
    )
    assert not findings_of(write_robot(update(position={"L_HAA": [low, high + 0.019]})))
    assert findings_of(write_robot(update(position={"L_HAA": [low, high + 0.021]})))


def test_efforts_of_twins_are_equal(write_robot: WriteRobot) -> None:
    found = findings_of(write_robot(update(effort={"L_HAA": 50.0})))
    assert "torque limit of 50 N m, R_HAA" in found["joint L_HAA"].found


def test_a_joint_that_turns_more_than_once_is_suspicious(write_robot: WriteRobot) -> None:
    found = findings_of(write_robot(update(position={"B_TR": [-6.0, 6.0]})))
    assert "turns from -6 to 6 rad" in found["joint B_TR"].found


# links


def with_link(mass: float, moments: tuple[float, float, float]) -> Callable[[str], str]:
    """Fix a link to the torso."""
    ixx, iyy, izz = moments
    part = (
        f'<link name="box"><inertial><mass value="{mass}"/><inertia ixx="{ixx}" iyy="{iyy}" '
        f'izz="{izz}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="box_fixed" type="fixed"><parent link="torso"/><child link="box"/></joint>'
    )
    return lambda text: text.replace("</robot>", part + "</robot>")


@pytest.mark.parametrize(
    ("mass", "moments", "severity"),
    [
        (1.0, (1e-3, 1e-3, 1e-3), None),
        (0.0, (0.0, 0.0, 0.0), None),
        (1.0, (0.0, 0.0, 0.0), "warning"),
        (1.0, (1e-3, 1e-3, 3e-3), "warning"),
        (1.1 * SLIGHT, (0.0, 0.0, 0.0), "warning"),
        (0.9 * SLIGHT, (0.0, 0.0, 0.0), "note"),
        (0.0, (1e-3, 1e-3, 1e-3), "note"),
    ],
)
def test_a_fixed_link_that_cannot_be_is_found(
    mass: float, moments: tuple[float, float, float], severity: str | None, write_robot: WriteRobot
) -> None:
    robot = load_robot(write_robot(urdf=with_link(mass, moments)))
    found = list(impossible_links(read_description(robot.source_path, "urdf"), "mine.yaml"))
    assert [finding.severity for finding in found] == ([] if severity is None else [severity])
    if severity is not None:
        assert found[0].element == "link box"
        assert "in mine.yaml: links: {box: {" in found[0].remedy


# motions


def test_torques_of_a_squat_are_those_of_the_statics(robot: Robot, controller: Controller) -> None:
    demands = demands_of(robot, controller, Squat(0.001, 0.05))
    command = controller.command()
    tick = controller.tick(robot.home, command)
    expected = float(np.max(np.abs(tick.tau) / robot.torque_limit))
    assert demands.torque is not None
    assert demands.torque.value == pytest.approx(expected, rel=0.02)
    assert demands.torque.of in ("L_KFE", "R_KFE")
    assert demands.friction is not None and demands.friction.value < 1e-3


def test_a_share_of_torque_is_of_what_a_motor_has_at_rest(
    robot: Robot, controller: Controller, write_robot: WriteRobot
) -> None:
    usual = torque_at_rest(robot, controller)
    limit = float(robot.torque_limit[robot.joint_names.index(usual.of)])
    half = {"stall_torque": 0.5 * limit, "no_load_speed": 9.0}
    slow = load_robot(write_robot(update(torque_speed={usual.of: half})))
    # the ticks are those of the same robot: standing needs less than a half
    assert usual.value < 0.5
    assert torque_at_rest(slow, controller).value == pytest.approx(2 * usual.value)


def test_a_sway_moves_the_centre_of_pressure_by_the_cart_table(
    robot: Robot, controller: Controller
) -> None:
    """Compare with y - z / g * ydd, a point mass; the limbs' turning is left."""
    amplitude, frequency = 0.08, 0.25
    demands = demands_of(robot, controller, Sway(amplitude, frequency))
    omega = 2 * np.pi * frequency
    swing = amplitude * (1 + omega**2 * float(robot.home_com[2]) / 9.81)
    # soles end 15 cm from the middle
    assert demands.pressure == pytest.approx(0.15 - swing, abs=3e-3)


def test_the_sag_of_a_wrong_model_counts(
    write_robot: WriteRobot, robot: Robot, controller: Controller
) -> None:
    stiff = demands_of(robot, controller, Squat(0.03, 0.25))
    assert stiff.joint is not None
    knee = robot.joint_names.index("L_KFE")
    lowest = min(float(q.q[7 + knee]) for q in stiff.extremes)
    # a limit that the squat itself just keeps, the one that is sagged does not
    limits = {"._KFE": [lowest - 0.02, 2.4]}
    limited = load_robot(write_robot(update(position=limits, postures={})))
    demands = demands_of(limited, controller, Squat(0.03, 0.25))
    assert demands.failure is None
    assert demands.joint is not None
    assert demands.joint.value == 0.0
    assert demands.joint.of in ("L_KFE", "R_KFE")


def test_a_motion_out_of_reach_fails(robot: Robot, controller: Controller) -> None:
    demands = demands_of(robot, controller, Squat(0.5, 0.25))
    assert demands.failure is not None
    assert demands.joint is None


# everything


def test_the_shipped_robot_works(robot: Robot, controller: Controller) -> None:
    seen: list[tuple[int, int]] = []
    examination = examine(robot, controller, lambda done, total: seen.append((done, total)))
    assert examination.works
    assert examination.findings == ()
    motions = {demands.motion.name for demands in examination.demands}
    assert motions == {"squat", "sway", "lean", "circle", "twist"}
    assert seen[-1] == (len(examination.demands), len(examination.demands))
    plain = examination.plain()
    assert plain["works"] is True
    assert all(motion["torque"]["value"] > 0 for motion in plain["motions"])


def test_a_range_that_is_out_of_reach_is_an_error(
    write_robot: WriteRobot, controller: Controller
) -> None:
    path = write_robot(lambda d: d["motions"]["squat"].update(amplitude=[0.001, 0.5]))
    robot = load_robot(path)
    examination = examine(robot, controller)
    assert not examination.works
    first = examination.findings[0]
    assert first.severity == "error"
    assert first.element.startswith("squat amplitude=0.5")
    assert "out of reach" in first.found


@pytest.mark.parametrize(("share", "is_home"), [(0.85, False), (0.95, True)])
def test_a_torque_that_standing_takes_is_not_blamed_on_a_range(
    share: float, is_home: bool, write_robot: WriteRobot, robot: Robot, controller: Controller
) -> None:
    tau = np.abs(controller.tick(robot.home, controller.command()).tau)
    knee = float(tau[robot.joint_names.index("L_KFE")])
    limited = load_robot(write_robot(update(effort={"._KFE": knee / share})))
    assert torque_at_rest(limited, controller).value == pytest.approx(share, rel=0.02)
    torques = [each for each in examine(limited, controller).findings if "torque of" in each.found]
    assert torques
    for finding in torques:
        told = "another home posture, home alone needs 9" in finding.remedy
        assert told is is_home
        assert ("effort: {" in finding.remedy) is is_home
        assert ("a smaller range" in finding.remedy) is not is_home


def test_an_override_settles_a_link(write_robot: WriteRobot, controller: Controller) -> None:
    path = write_robot(urdf=with_link(1.0, (0.0, 0.0, 0.0)))
    robot = load_robot(path)
    (finding,) = examine(robot, controller).findings
    assert finding.element == "link box"
    path.write_text(path.read_text() + finding.remedy.split(": ", 1)[1] + "\n")
    mended = load_robot(path)
    assert examine(mended, controller).findings == ()
