from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.description_path import find_package, resolve_path


@pytest.fixture
def robot_file(tmp_path: Path) -> Path:
    folder = tmp_path / "robot"
    (folder / "urdf").mkdir(parents=True)
    (folder / "urdf" / "a.urdf").write_text("<robot/>")
    (tmp_path / "outside.urdf").write_text("<robot/>")
    (folder / "link.urdf").symlink_to(tmp_path / "outside.urdf")
    return folder / "robot.yaml"


def test_a_path_is_relative_to_the_robot_file(robot_file: Path) -> None:
    found = resolve_path(robot_file, "urdf", "urdf/a.urdf")
    assert found == robot_file.parent / "urdf" / "a.urdf"


@pytest.mark.parametrize("way", ["../outside.urdf", "urdf/../../outside.urdf", "link.urdf"])
def test_a_path_that_leaves_the_folder_is_refused(way: str, robot_file: Path) -> None:
    with pytest.raises(RobotFileError, match="leaves the folder") as caught:
        resolve_path(robot_file, "urdf", way)
    assert caught.value.field == "urdf"


@pytest.mark.parametrize("name", ["gone.urdf", "urdf", "", "a\0b", "x" * 5000])
def test_a_path_of_no_file_is_told(name: str, robot_file: Path) -> None:
    with pytest.raises(RobotFileError, match="is no file"):
        resolve_path(robot_file, "urdf", name)


@pytest.mark.parametrize("variable", ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "sys.path"])
def test_a_package_is_found_without_ros(
    variable: str, robot_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    below = {"AMENT_PREFIX_PATH": "share", "sys.path": "cmeel.prefix/share"}.get(variable, "")
    folder = tmp_path / "prefix" / below / "my_robots"
    folder.mkdir(parents=True)
    (folder / "a.urdf").write_text("<robot/>")
    assert find_package("my_robots") is None
    if variable == "sys.path":
        monkeypatch.syspath_prepend(str(tmp_path / "prefix"))
    else:
        monkeypatch.setenv(variable, os.pathsep.join(["/nowhere", str(tmp_path / "prefix")]))
    assert resolve_path(robot_file, "urdf", "package://my_robots/a.urdf") == folder / "a.urdf"
    with pytest.raises(RobotFileError, match="leaves the folder"):
        resolve_path(robot_file, "urdf", "package://my_robots/../../outside.urdf")


@pytest.mark.parametrize("name", ["not_there", "", "..", "."])
def test_a_package_that_is_not_there_is_told(name: str, robot_file: Path) -> None:
    with pytest.raises(RobotFileError, match="is not installed") as caught:
        resolve_path(robot_file, "urdf", f"package://{name}/a.urdf")
    assert "ROS_PACKAGE_PATH" in str(caught.value)
    assert sys.path  # where it was looked for
