from __future__ import annotations

import builtins
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tsd_casadi import Robot, load_robot
from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.description import LARGEST_FILE, kind_of, read_description

WriteRobot = Callable[..., Path]

XACRO = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"'


def as_xacro(text: str) -> str:
    """Write the pelvis' mass as a property, which only xacro knows."""
    text = text.replace("<robot", XACRO, 1)
    head, tail = text.split(">", 1) if text.startswith("<robot") else split_root(text)
    property_ = '<xacro:property name="m" value="${2 * 4.97}"/>'
    return f"{head}>{property_}{tail}".replace('<mass value="9.94"/>', '<mass value="${m}"/>', 1)


def split_root(text: str) -> tuple[str, str]:
    start = text.index("<robot")
    end = text.index(">", start)
    return text[:end], text[end + 1 :]


def test_xacro_is_expanded(write_robot: WriteRobot, robot: Robot) -> None:
    pytest.importorskip("xacro")
    expanded = load_robot(write_robot(urdf=as_xacro))
    assert "${m}" in expanded.source_path.read_text()
    assert expanded.body_fingerprint == robot.body_fingerprint
    assert expanded.weight == pytest.approx(robot.weight)


def test_xacro_is_refused_by_name_where_it_cannot_be_expanded(
    write_robot: WriteRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = builtins.__import__

    def without(name: str, *args: Any, **options: Any) -> Any:
        if name == "xacro":
            raise ImportError(name)
        return original(name, *args, **options)

    monkeypatch.setattr(builtins, "__import__", without)
    path = write_robot(urdf=as_xacro)
    with pytest.raises(RobotFileError, match="is xacro") as caught:
        load_robot(path)
    assert "pip install xacro" in str(caught.value)
    assert caught.value.path.suffix == ".urdf"


def test_xacro_that_needs_ros_is_told(write_robot: WriteRobot) -> None:
    pytest.importorskip("xacro")
    path = write_robot(urdf=lambda text: as_xacro(text).replace("4.97", "$(find nowhere)"))
    with pytest.raises(RobotFileError, match="cannot be expanded as xacro"):
        load_robot(path)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "cannot be parsed as XML"),
        ("<robot", "cannot be parsed as XML"),
        ("<sdf/>", "is <sdf>"),
        ("<mujoco/>", "is an MJCF; expected the element <robot> at its root; name it as 'mjcf'"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><robot>&b;</robot>', "declares XML entities"),
    ],
)
def test_what_is_no_urdf_is_told(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "a.urdf"
    path.write_text(text)
    with pytest.raises(RobotFileError) as caught:
        read_description(path, "urdf")
    assert said in str(caught.value)


def test_a_description_has_a_largest_size(tmp_path: Path) -> None:
    path = tmp_path / "a.urdf"
    start, end = "<robot><!--", "--></robot>"
    fits = LARGEST_FILE - len(start) - len(end)
    path.write_text(start + "x" * fits + end)
    assert read_description(path, "urdf").root.tag == "robot"
    path.write_text(start + "x" * (fits + 1) + end)
    with pytest.raises(RobotFileError, match="too large"):
        read_description(path, "urdf")


def test_the_kind_is_told_by_what_is_in_the_file(tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    path.write_text("<mujoco/>")
    assert kind_of(path) == "mjcf"
    path.write_text("<robot/>")
    assert kind_of(path) == "urdf"
    path.write_text("<sdf/>")
    with pytest.raises(RobotFileError, match="<sdf> at its root"):
        kind_of(path)


# the shipped robot's scene describes the same bodies as its URDF


def as_mjcf(document: Any) -> None:
    """Take links and joints from the scene's file, which has frames for no sole."""
    del document["urdf"]
    document["mjcf"] = "hermes_lower.xml"
    for contact, foot in zip(document["contacts"], ("L_foot", "R_foot"), strict=True):
        contact["frame"] = foot
        contact["offset"] = {"xyz": [0.045, 0.0, -0.064]}


def test_an_mjcf_alone_is_the_same_robot(write_robot: WriteRobot, robot: Robot) -> None:
    path = write_robot(as_mjcf)
    mjcf = load_robot(path)
    assert mjcf.joint_names == robot.joint_names
    assert mjcf.weight == pytest.approx(robot.weight, rel=1e-6)
    assert mjcf.home_com == pytest.approx(robot.home_com, abs=1e-6)
    # of its motors
    assert mjcf.torque_limit == pytest.approx(robot.torque_limit)


def test_an_mjcf_without_motors_gets_its_efforts_from_the_robot_file(
    write_robot: WriteRobot, robot: Robot
) -> None:
    path = write_robot(as_mjcf)
    scene = path.parent / "hermes_lower.xml"
    text = scene.read_text()
    start, end = text.index("<actuator>"), text.index("</actuator>") + len("</actuator>")
    scene.write_text(text[:start] + text[end:])
    with pytest.raises(RobotFileError, match="effort"):
        load_robot(path)
    path.write_text(path.read_text() + "effort: {'.*': 99.0}\n")
    assert (load_robot(path).torque_limit == 99.0).all()


def test_other_masses_go_into_an_mjcf_too(write_robot: WriteRobot, robot: Robot) -> None:
    def edit(document: Any) -> None:
        as_mjcf(document)
        document["links"] = {"torso": {"mass": 20.0}}

    heavier = load_robot(write_robot(edit))
    joint = heavier.model.getJointId("B_TFE")
    assert heavier.model.inertias[joint].mass == pytest.approx(20.0)


def test_an_mjcf_without_a_free_joint_gets_one(write_robot: WriteRobot, robot: Robot) -> None:
    path = write_robot(as_mjcf)
    scene = path.parent / "hermes_lower.xml"
    scene.write_text(scene.read_text().replace('<freejoint name="base"/>', ""))
    assert load_robot(path).nq == robot.nq


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "<worldbody>",
            '<worldbody><body name="b"><freejoint/><geom size="1"/></body>',
            "2 bodies",
        ),
        (
            '<joint name="B_TAA"',
            '<joint name="second" axis="0 1 0"/><joint name="B_TAA"',
            "body torso_roll has several joints",
        ),
        ('mass="22.85"', 'mass="x"', "cannot be parsed"),
    ],
)
def test_an_mjcf_that_is_no_robot_is_told(
    old: str, new: str, said: str, write_robot: WriteRobot
) -> None:
    path = write_robot(as_mjcf)
    scene = path.parent / "hermes_lower.xml"
    text = scene.read_text()
    assert old in text
    scene.write_text(text.replace(old, new, 1))
    with pytest.raises(RobotFileError) as caught:
        load_robot(path)
    assert said in str(caught.value)


def test_a_robot_is_loaded_without_mujoco() -> None:
    program = "import sys; from tsd_casadi import load_robot; load_robot('hermes_lower'); "
    program += "assert 'mujoco' not in sys.modules"
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
