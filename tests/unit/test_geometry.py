from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import coal
import numpy as np
import pinocchio
import pytest

from tsd_casadi import Robot, load_robot
from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.description import read_description
from tsd_casadi.robot.geometry import load_geometry
from tsd_casadi.robot.mesh_path import find_mesh
from tsd_casadi.robot.rigid_body_model import RigidBodyModel

WriteRobot = Callable[..., Path]
PELVIS = '<geometry><box size="0.18 0.28 0.16"/></geometry>'
# a tetrahedron
SOLID = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def mesh(file: str) -> Callable[[str], str]:
    return lambda text: text.replace(
        PELVIS, f'<geometry><mesh filename="{file}" scale="0.1 0.1 0.1"/></geometry>'
    )


def test_shapes_are_on_the_joints_that_move_their_links(robot: Robot) -> None:
    geometry = load_geometry(robot.bodies, "visual")
    assert geometry.missing == ()
    by_link = {shape.name.rsplit("_", 1)[0]: shape for shape in geometry.model.geometryObjects}
    assert {"pelvis", "torso", "L_thigh", "R_foot"} <= by_link.keys()
    for link, shape in by_link.items():
        frame = robot.model.frames[robot.bodies.find_frame(link)]
        assert shape.parentJoint == frame.parentJoint
    pelvis = by_link["pelvis"]
    assert isinstance(pelvis.geometry, coal.Box)
    np.testing.assert_allclose(pelvis.geometry.halfSide, [0.09, 0.14, 0.08])
    np.testing.assert_allclose(pelvis.placement.translation, [0, 0, 0.05])


def test_what_is_seen_is_not_what_collides(robot: Robot) -> None:
    seen, colliding = (load_geometry(robot.bodies, use).model for use in ("visual", "collision"))
    assert seen.ngeoms != colliding.ngeoms


def test_only_links_that_are_named_are_loaded(robot: Robot) -> None:
    geometry = load_geometry(robot.bodies, "visual", ["L_foot", "torso"])
    names = sorted(shape.name for shape in geometry.model.geometryObjects)
    assert names == ["L_foot_0", "torso_0"]


def test_shapes_behind_a_locked_joint_follow_its_angle(write_robot: WriteRobot) -> None:
    angle = 0.3

    def lock(document: Any) -> None:
        document["locked"] = {"B_TFE": angle}
        del document["postures"]

    robot = load_robot(write_robot(lock))
    geometry = load_geometry(robot.bodies, "visual", ["torso"])
    (shape,) = geometry.model.geometryObjects
    assert robot.model.names[shape.parentJoint] == "B_TAA"
    turned = pinocchio.SE3(pinocchio.rpy.rpyToMatrix(0, angle, 0), np.array([0, 0, 0.03]))
    expected = turned.act(np.array([0.01, 0, 0.2]))
    np.testing.assert_allclose(shape.placement.translation, expected, atol=1e-12)


@pytest.mark.parametrize(
    "written",
    [
        "meshes/pelvis.obj",
        "package://hermes_lower/meshes/pelvis.obj",
        "package:///hermes_lower/meshes/pelvis.obj",
        "model://hermes_lower/meshes/pelvis.obj",
        "file://{folder}/meshes/pelvis.obj",
        "{folder}/meshes/pelvis.obj",
    ],
)
def test_a_mesh_is_found_however_it_is_named(write_robot: WriteRobot, written: str) -> None:
    path = write_robot()
    folder = path.parent
    (folder / "meshes").mkdir()
    (folder / "meshes" / "pelvis.obj").write_text(SOLID)
    urdf = folder / "hermes_lower.urdf"
    urdf.write_text(mesh(written.format(folder=folder))(urdf.read_text()))
    geometry = load_geometry(load_robot(path).bodies, "visual", ["pelvis"])
    assert geometry.missing == ()
    (shape,) = geometry.model.geometryObjects
    np.testing.assert_allclose(shape.geometry.vertices().max(axis=0), [0.1, 0.2, 0.3])


def test_a_mesh_of_another_package_is_found_by_ros_variables(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    description = tmp_path / "robot" / "robot.urdf"
    for variable, place in (("ROS_PACKAGE_PATH", "a"), ("AMENT_PREFIX_PATH", "b/share")):
        file = tmp_path / place / "of_others" / "arm 1.stl"
        file.parent.mkdir(parents=True)
        file.write_text("")
        assert find_mesh(description, "package://of_others/arm%201.stl") is None
        monkeypatch.setenv(variable, f"{tmp_path / 'nowhere'}:{tmp_path / place.split('/')[0]}")
        assert find_mesh(description, "package://of_others/arm%201.stl") == file
        monkeypatch.delenv(variable)


def test_a_repository_may_have_another_name_than_its_package(tmp_path: Path) -> None:
    root = tmp_path / "arm-main"
    (root / "urdf").mkdir(parents=True)
    (root / "package.xml").write_text("<package/>")
    (root / "arm.stl").write_text("")
    assert find_mesh(root / "urdf" / "arm.urdf", "package://arm/arm.stl") == root / "arm.stl"


@pytest.mark.parametrize(
    "written", ["gone.stl", "package://gone/a.stl", "package://", "", "file://"]
)
def test_what_is_not_there_is_none(robot: Robot, written: str) -> None:
    assert find_mesh(robot.source_path, written) is None


def test_missing_meshes_are_named_once_and_the_rest_is_loaded(write_robot: WriteRobot) -> None:
    there = load_robot(write_robot())
    whole = load_geometry(there.bodies, "visual").model.ngeoms
    robot = load_robot(write_robot(urdf=mesh("package://gone/pelvis.stl")))
    geometry = load_geometry(robot.bodies, "visual")
    assert geometry.missing == ("package://gone/pelvis.stl",)
    assert geometry.model.ngeoms == whole - 1


def test_a_mesh_that_cannot_be_read_is_an_error_of_the_description(
    write_robot: WriteRobot, capfd: Any
) -> None:
    path = write_robot(urdf=mesh("pelvis.stl"))
    (path.parent / "pelvis.stl").write_text("solid nothing")
    robot = load_robot(path)
    with pytest.raises(RobotFileError, match="names a mesh that cannot be read") as caught:
        load_geometry(robot.bodies, "visual")
    assert caught.value.path == robot.source_path
    assert capfd.readouterr().err == ""


def test_loading_leaves_the_description_as_it_was(robot: Robot) -> None:
    before = robot.bodies.description.text
    load_geometry(robot.bodies, "collision", [])
    assert robot.bodies.description.text == before


MJCF = """
<mujoco model="box">
  <compiler meshdir="meshes"/>
  <asset><mesh name="there" file="there.obj"/><mesh file="gone.obj"/></asset>
  <worldbody>
    <body name="base">
      <freejoint/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
      <geom type="box" size="0.1 0.2 0.3" pos="0 0 0.5"/>
      <body name="leg" pos="0 0 1">
        <joint name="hip" axis="0 1 0" range="-1 1"/>
        <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
        <geom type="mesh" mesh="there"/>
        <geom type="mesh" mesh="gone"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def test_an_mjcf_has_shapes_too(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "there.obj").write_text(SOLID)
    path = tmp_path / "box.xml"
    path.write_text(MJCF)
    fields = ("locked", "effort", "velocity", "position", "links")
    file: Any = SimpleNamespace(**{field: {} for field in fields}, contacts=(), all_tasks=())
    bodies = RigidBodyModel(tmp_path / "box.yaml", file, read_description(path, "mjcf"))
    geometry = load_geometry(bodies, "collision")
    assert geometry.missing == ("gone.obj",)
    parents = [bodies.model.names[s.parentJoint] for s in geometry.model.geometryObjects]
    assert len(parents) == 2
    assert parents[1] == "hip"
    only = load_geometry(bodies, "collision", ["leg"])
    assert [bodies.model.names[s.parentJoint] for s in only.model.geometryObjects] == ["hip"]
