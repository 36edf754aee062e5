from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import pytest
from scipy.optimize import least_squares

from tsd_casadi import Robot, load_robot
from tsd_casadi.exceptions import InvalidValue, RobotFileError, TsdError, UnknownRobot

WriteRobot = Callable[..., Path]


def test_shipped_robot_is_found_by_name_and_by_path(robot: Robot) -> None:
    same = load_robot(robot.path)
    assert same.fingerprint == robot.fingerprint
    assert same.joint_names == robot.joint_names


def test_unknown_robot_lists_the_known_ones(robot: Robot) -> None:
    with pytest.raises(UnknownRobot, match="no_such_robot") as caught:
        load_robot("no_such_robot")
    assert robot.name in caught.value.known
    assert robot.name in str(caught.value)
    assert ".yaml" in str(caught.value)


@pytest.mark.parametrize("name", ["x" * 5000, "~no_such_user/robot.yaml", "a\0b", "", "/", "."])
def test_what_cannot_be_a_path_is_no_robot(name: str) -> None:
    with pytest.raises(UnknownRobot) as caught:
        load_robot(name)
    assert caught.value.name == name


def test_robot_loads_from_a_folder_elsewhere(robot: Robot, write_robot: WriteRobot) -> None:
    other = load_robot(str(write_robot()))
    assert other.weight == robot.weight
    np.testing.assert_array_equal(other.home.q, robot.home.q)


def test_fingerprint_follows_both_files(robot: Robot, write_robot: WriteRobot) -> None:
    same_file = write_robot()
    same_file.write_bytes(robot.path.read_bytes())
    assert load_robot(same_file).fingerprint == robot.fingerprint
    heavier = write_robot(urdf=lambda text: text.replace("9.94", "9.95"))
    heavier.write_bytes(robot.path.read_bytes())
    other_urdf = load_robot(heavier).fingerprint
    softer = load_robot(write_robot(lambda d: d["tasks"][0].update(P=49.0))).fingerprint
    assert len({robot.fingerprint, other_urdf, softer}) == 3


def test_sizes_names_and_limits(robot: Robot) -> None:
    assert robot.n == len(robot.joint_names) == 17
    assert (robot.nq, robot.nv) == (24, 23)
    for name, limit in zip(robot.joint_names, robot.torque_limit, strict=True):
        block = re.search(rf'<joint name="{name}".*?</joint>', robot.source_path.read_text(), re.S)
        assert block is not None
        assert f'effort="{limit:g}"' in block[0]


def error_of(path: Path) -> RobotFileError:
    with pytest.raises(RobotFileError) as caught:
        load_robot(path)
    assert str(caught.value.path) in str(caught.value)
    return caught.value


def rename_frame(kind: str, index: int) -> Callable[[Any], object]:
    return lambda document: document[kind][index].update(frame="nowhere")


@pytest.mark.parametrize(("kind", "index"), [("contacts", 1), ("tasks", 2)])
def test_unknown_frame(kind: str, index: int, write_robot: WriteRobot) -> None:
    error = error_of(write_robot(rename_frame(kind, index)))
    assert error.field == f"{kind}.{index}.frame"
    assert "'nowhere'" in str(error)
    assert error.expected.startswith("one of ")
    assert error.expected.endswith("others")


def test_unknown_home_joint(write_robot: WriteRobot) -> None:
    error = error_of(write_robot(lambda d: d["home"].update(L_ELBOW=0.1)))
    assert error.field == "home.L_ELBOW"
    assert "L_KFE" in error.expected


@pytest.mark.parametrize("angle", [-0.1, 2.5])
def test_home_outside_limits(angle: float, write_robot: WriteRobot) -> None:
    error = error_of(write_robot(lambda d: d["home"].update(L_KFE=angle)))
    assert error.field == "home.L_KFE"
    assert "from 0 to 2.4 rad" in error.expected


@pytest.mark.parametrize("joint", ["L_KFE", "R_AFE", "L_AAA"])
def test_feet_not_flat(joint: str, write_robot: WriteRobot) -> None:
    def bend(document: Any) -> None:
        document["home"][joint] = document["home"].get(joint, 0.0) + 0.05

    error = error_of(write_robot(bend))
    assert error.field == "home"
    assert re.search(r"(left|right)_foot tilted by [\d.]+ rad", str(error))
    assert "flat" in error.expected


@pytest.mark.parametrize("field", ["urdf", "scene"])
@pytest.mark.parametrize("name", ["gone.xml", "x" * 5000, ".", "a\0b"])
def test_missing_file(field: str, name: str, write_robot: WriteRobot) -> None:
    error = error_of(write_robot(lambda d: d.update({field: name})))
    assert error.field == field
    assert name in str(error)
    assert "relative to this file" in error.expected


@pytest.mark.parametrize(
    "urdf",
    [
        lambda text: text[: len(text) // 2],
        lambda text: "no xml at all",
        lambda text: "",
        lambda text: text.replace('<parent link="pelvis"/>', '<parent link="nothing"/>', 1),
    ],
    ids=["cut off", "no XML", "empty", "unknown parent"],
)
def test_broken_urdf(urdf: Callable[[str], str], write_robot: WriteRobot) -> None:
    error = error_of(write_robot(urdf=urdf))
    assert error.path.suffix == ".urdf"
    assert "cannot be parsed" in str(error)
    assert error.expected in ("a valid URDF", "a valid URDF or MJCF")


def test_the_reason_of_the_parser_is_told(
    write_robot: WriteRobot, capfd: pytest.CaptureFixture[str]
) -> None:
    error = error_of(
        write_robot(
            urdf=lambda text: text.replace('<parent link="pelvis"/>', '<parent link="no"/>', 1)
        )
    )
    assert "parent link [no]" in str(error)
    assert "not found" in str(error)
    assert not capfd.readouterr().err


@pytest.mark.parametrize("effort", ["0", "1e9"])
def test_joint_without_a_torque_limit(effort: str, write_robot: WriteRobot) -> None:
    error = error_of(
        write_robot(urdf=lambda text: text.replace('effort="350"', f'effort="{effort}"', 1))
    )
    assert "L_KFE" in error.field
    assert "effort" in error.field
    assert "positive torque limit" in error.expected


def test_negative_torque_limit_is_refused(write_robot: WriteRobot) -> None:
    error = error_of(write_robot(urdf=lambda text: text.replace('effort="350"', 'effort="-5"', 1)))
    assert error.path.suffix == ".urdf"


def test_continuous_joint_is_refused(write_robot: WriteRobot) -> None:
    def continuous(text: str) -> str:
        return text.replace('name="B_TR" type="revolute"', 'name="B_TR" type="continuous"')

    error = error_of(write_robot(urdf=continuous))
    assert "continuous" in str(error)


def test_planar_joint_is_refused(write_robot: WriteRobot) -> None:
    error = error_of(
        write_robot(
            urdf=lambda text: text.replace('"B_TR" type="revolute"', '"B_TR" type="planar"')
        )
    )
    assert "joint B_TR is of the type Planar" in str(error)
    assert "'locked: {B_TR: 0.0}'" in error.expected


def test_every_error_is_one_of_ours(write_robot: WriteRobot) -> None:
    with pytest.raises(TsdError):
        load_robot(write_robot(lambda d: d.clear()))


def test_home_is_at_rest_with_flat_soles_on_the_ground(robot: Robot) -> None:
    assert not robot.home.v.any()
    data = robot.model.createData()
    pinocchio.framesForwardKinematics(robot.model, data, robot.home.q)
    for contact in robot.description.contacts:
        sole = data.oMf[robot.model.getFrameId(contact.frame)]
        assert sole.translation[2] == pytest.approx(0, abs=1e-6)
        np.testing.assert_allclose(sole.rotation[:, 2], [0, 0, 1], atol=1e-6)


def test_tall_has_its_knees_at_one_radian_and_flat_soles(robot: Robot) -> None:
    tall = robot.posture("tall")
    assert not tall.v.any()
    for joint in ("L_KFE", "R_KFE"):
        assert tall.q[7 + robot.joint_names.index(joint)] == 1.0
    for sole in robot.sole_placements(tall.q):
        assert sole.translation[2] == pytest.approx(0, abs=1e-4)
        np.testing.assert_allclose(sole.rotation[:, 2], [0, 0, 1], atol=1e-4)
    # higher than home, in balance, upright
    assert robot.center_of_mass(tall.q)[2] > robot.home_com[2] + 0.04
    for contact, sole in zip(
        robot.description.contacts, robot.sole_placements(tall.q), strict=True
    ):
        assert contact.x[0] < robot.center_of_mass(tall.q)[0] - sole.translation[0] < contact.x[1]
    np.testing.assert_array_equal(tall.q[3:7], [0, 0, 0, 1])


def test_home_is_a_posture_too(robot: Robot) -> None:
    assert robot.posture("home") is robot.home


@pytest.mark.parametrize("name", ["small", "", "Tall", "HOME"])
def test_unknown_postures_are_refused_with_the_known_ones(robot: Robot, name: str) -> None:
    with pytest.raises(InvalidValue, match=f"posture is '{name}', expected one of home, tall"):
        robot.posture(name)


@pytest.mark.parametrize(
    ("change", "field", "told"),
    [
        ({"L_ELBOW": 0.1}, "postures.tall.L_ELBOW", "L_KFE"),
        ({"L_KFE": 2.5}, "postures.tall.L_KFE", "from 0 to 2.4 rad"),
        ({"R_KFE": 1.1}, "postures.tall", "flat"),
    ],
    ids=["unknown joint", "out of limits", "not flat"],
)
def test_other_postures_are_checked_like_home(
    write_robot: WriteRobot, change: dict[str, float], field: str, told: str
) -> None:
    error = error_of(write_robot(lambda document: document["postures"]["tall"].update(change)))
    assert error.field == field
    assert told in error.expected


def test_put_on_ground_moves_the_base_up_and_down_only(robot: Robot) -> None:
    q = robot.home.q.copy()
    q[:3] = 0.3, -0.2, 5.0
    q[7 + robot.joint_names.index("L_KFE")] += 0.2
    before, grounded = q.copy(), robot.put_on_ground(q)
    np.testing.assert_array_equal(q, before)
    assert set(np.flatnonzero(grounded != q)) == {2}
    heights = [sole.translation[2] for sole in robot.sole_placements(grounded)]
    assert heights[0] == pytest.approx(-heights[1], abs=1e-12)
    assert abs(heights[0]) > 1e-3


def test_soles_are_placed_like_any_frame(robot: Robot) -> None:
    q = pinocchio.randomConfiguration(robot.model, -np.ones(robot.nq), np.ones(robot.nq))
    for contact, sole in zip(robot.description.contacts, robot.sole_placements(q), strict=True):
        position, _ = robot.frame_placement(contact.frame, q)
        np.testing.assert_allclose(sole.translation, position, atol=1e-12)


def test_home_balances_over_the_soles(robot: Robot) -> None:
    for contact in robot.description.contacts:
        position, _ = robot.frame_placement(contact.frame, robot.home.q)
        assert contact.x[0] < robot.home_com[0] - position[0] < contact.x[1]


def test_weight_is_that_of_the_urdf(robot: Robot) -> None:
    masses = re.findall(r'<mass value="([\d.]+)"', robot.source_path.read_text())
    assert robot.weight == pytest.approx(sum(map(float, masses)) * 9.81)


def test_frame_placement_is_position_and_unit_quaternion(robot: Robot) -> None:
    q = robot.home.q.copy()
    q[3:7] = np.array([0.1, -0.2, 0.3, 0.9]) / np.linalg.norm([0.1, -0.2, 0.3, 0.9])
    position, quaternion = robot.frame_placement("pelvis", q)
    np.testing.assert_allclose(position, q[:3], atol=1e-12)
    np.testing.assert_allclose(quaternion * np.sign(quaternion[3]), q[3:7], atol=1e-12)


@pytest.mark.parametrize("rise", [-0.08, -0.04, 0.04, 0.08])
def test_center_of_mass_can_travel_inside_the_joint_limits(robot: Robot, rise: float) -> None:
    q = posture_with_raised_com(robot, rise)
    low, high = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
    margin = np.minimum(q[7:] - low, high - q[7:])
    assert margin.min() > 0.1, robot.joint_names[int(margin.argmin())]


def posture_with_raised_com(robot: Robot, rise: float) -> np.ndarray:
    model, home = robot.model, robot.home.q
    soles = [model.getFrameId(contact.frame) for contact in robot.description.contacts]
    upright = [model.getFrameId(name) for name in ("pelvis", "torso")]

    def frames(q: np.ndarray) -> Any:
        data = model.createData()
        pinocchio.framesForwardKinematics(model, data, q)
        return [data.oMf[frame].copy() for frame in (*soles, *upright)]

    wanted = frames(home)
    wanted_com = robot.home_com + np.array([0, 0, rise])

    def residual(step: np.ndarray) -> np.ndarray:
        q = pinocchio.integrate(model, home, step)
        errors = [
            pinocchio.log6(a.actInv(b)).vector for a, b in zip(wanted, frames(q), strict=True)
        ]
        errors[len(soles) :] = [error[3:] for error in errors[len(soles) :]]
        com = pinocchio.centerOfMass(model, model.createData(), q)
        return np.concatenate((*errors, com - wanted_com))

    found = least_squares(residual, np.zeros(model.nv), method="trf", xtol=1e-12, gtol=1e-12)
    assert np.abs(residual(found.x)).max() < 1e-8
    return np.asarray(pinocchio.integrate(model, home, found.x))


def test_legs_that_cannot_move_their_feet_freely_are_a_robot(write_robot: WriteRobot) -> None:
    def lock_ankles(text: str) -> str:
        return re.sub(r'name="(._A(?:AA|R))" type="revolute"', r'name="\1" type="fixed"', text)

    assert load_robot(write_robot(urdf=lock_ankles)).n == 13


def test_a_robot_needs_no_scene(write_robot: Callable[..., Path]) -> None:
    robot = load_robot(write_robot(lambda document: document.pop("scene")))
    assert robot.n == 17
    assert robot.scene_path is None
