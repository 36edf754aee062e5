from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from tsd_casadi import Robot, load_robot
from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.identification.identified_robot import write_robot


def possible_inertia(rng: np.random.Generator) -> np.ndarray:
    """Of a body with mass at random places."""
    points = rng.normal(size=(10, 3))
    second = points.T @ points
    return np.asarray(0.01 * (np.trace(second) * np.eye(3) - second))


def random_inertias(robot: Robot) -> list[pinocchio.Inertia]:
    rng = np.random.default_rng(0)
    return [
        pinocchio.Inertia(
            inertia.mass * rng.uniform(0.5, 2.0),
            rng.uniform(-0.1, 0.1, 3),
            possible_inertia(rng),
        )
        for inertia in list(robot.model.inertias)[1:]
    ]


def test_only_the_inertias_change(robot: Robot, tmp_path: Path) -> None:
    before = robot.source_path.read_bytes()
    inertias = random_inertias(robot)
    written = write_robot(robot, inertias, tmp_path / "copy")
    for mine, theirs in zip(list(written.model.inertias)[1:], inertias, strict=True):
        np.testing.assert_allclose(
            mine.toDynamicParameters(), theirs.toDynamicParameters(), atol=1e-12
        )
    assert written.joint_names == robot.joint_names
    assert written.name == robot.name
    assert written.fingerprint != robot.fingerprint
    np.testing.assert_array_equal(written.home.q, robot.home.q)
    np.testing.assert_array_equal(written.torque_limit, robot.torque_limit)
    assert robot.source_path.read_bytes() == before
    assert load_robot(tmp_path / "copy" / robot.path.name).fingerprint == written.fingerprint


def test_its_own_inertias_make_the_same_robot(robot: Robot, tmp_path: Path) -> None:
    written = write_robot(robot, list(robot.model.inertias)[1:], tmp_path)
    q = robot.home.q
    np.testing.assert_allclose(written.center_of_mass(q), robot.home_com, atol=1e-12)
    assert written.weight == pytest.approx(robot.weight)


def test_links_on_fixed_joints_are_part_of_their_body(
    write_robot: Callable[..., Path], tmp_path: Path
) -> None:
    from tsd_casadi.identification.identified_robot import write_robot as write

    load = (
        '<link name="load"><inertial><origin xyz="0.1 0 0"/><mass value="3"/><inertia ixx="0.1" '
        'ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>'
        '<joint name="load_fixed" type="fixed"><parent link="pelvis"/><child link="load"/>'
        '<origin xyz="0 0 0.2" rpy="0.3 0 0"/></joint></robot>'
    )
    loaded = load_robot(write_robot(urdf=lambda text: text.replace("</robot>", load)))
    written = write(loaded, list(loaded.model.inertias)[1:], tmp_path / "written")
    for mine, theirs in zip(written.model.inertias, loaded.model.inertias, strict=True):
        np.testing.assert_allclose(
            mine.toDynamicParameters(), theirs.toDynamicParameters(), atol=1e-12
        )


@pytest.mark.parametrize("way", ["absolute", "upwards"])
def test_a_urdf_elsewhere_is_refused(
    robot: Robot, write_robot: Callable[..., Path], tmp_path: Path, way: str
) -> None:
    path = write_robot()
    moved = tmp_path / "elsewhere.urdf"
    moved.write_bytes(robot.source_path.read_bytes())
    named = str(moved) if way == "absolute" else os.path.relpath(moved, path.parent)
    text = path.read_text()
    path.write_text(text.replace(f"urdf: {robot.description.urdf}", f"urdf: {named}"))
    with pytest.raises(RobotFileError, match="leaves the folder"):
        load_robot(path)
