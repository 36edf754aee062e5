from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tsd_casadi import Robot, load_robot
from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.standing import stand
from tsd_clients.film import gl_library, rendering
from tsd_clients.film.gl_library import HINT
from tsd_clients.film.picture_scene import load_picture_scene
from tsd_clients.film.rendering import render_postures, side_by_side
from tsd_clients.film.visual_geoms import add_visuals
from tsd_clients.simulator.build_scene import build_scene
from tsd_clients.simulator.parity import measure_parity
from tsd_clients.simulator.state_map import StateMap


def test_a_lower_posture_is_a_lower_picture(robot: Robot) -> None:
    postures = np.array([stand(robot, height).q for height in (0.05, -0.05)])
    frames = render_postures(robot, postures, 60, 80)
    if frames is None:
        pytest.skip(HINT)
    assert frames.shape == (2, 80, 60, 3)
    assert frames.dtype == np.uint8
    # the same place is seen, something in it has moved
    assert 0 < np.mean(frames[0] != frames[1]) < 0.6
    assert side_by_side(frames).shape == (80, 120, 3)


@pytest.fixture
def bare_robot(write_robot: Callable[..., Path]) -> Callable[..., Robot]:
    """The robot without a scene, its description edited."""

    def load(urdf: Callable[[str], str] = lambda text: text) -> Robot:
        return load_robot(write_robot(lambda document: document.pop("scene"), urdf))

    return load


def _with_mesh(file: str) -> Callable[[str], str]:
    mesh = f'<geometry><mesh filename="{file}"/></geometry>'
    return lambda text: text.replace('<geometry><box size="0.18 0.28 0.16"/></geometry>', mesh)


def test_a_robot_without_a_scene_is_drawn_with_what_its_description_shows(
    bare_robot: Callable[..., Robot],
) -> None:
    robot = bare_robot()
    postures = np.array([stand(robot, height).q for height in (0.05, -0.05)])
    frames = render_postures(robot, postures, 60, 80)
    if frames is None:
        pytest.skip(HINT)
    assert 0 < np.mean(frames[0] != frames[1]) < 0.6
    # sky above, tiles below, and a robot in front of them
    assert len(np.unique(frames[0].reshape(-1, 3), axis=0)) > 100


def test_pictures_may_be_larger_than_a_scene_says(mini_biped: Robot) -> None:
    frames = render_postures(mini_biped, mini_biped.home.q[None, :], 400, 700)
    if frames is None:
        pytest.skip(HINT)
    assert frames.shape == (1, 700, 400, 3)


def test_shapes_of_a_description_are_where_its_links_are(
    bare_robot: Callable[..., Robot],
) -> None:
    robot = bare_robot()
    model = load_picture_scene(robot)
    data = mujoco.MjData(model)
    StateMap(robot, model).write(data, robot.home)
    mujoco.mj_forward(model, data)
    # what is seen changes nothing of the body
    assert max(vars(measure_parity(robot, model)).values()) < 1e-11
    boxes = [geom for geom in range(model.ngeom) if model.geom_contype[geom] == 0]
    sizes = model.geom_size[boxes]
    np.testing.assert_allclose(sizes.max(axis=0), [0.13, 0.17, 0.21], atol=0.05)
    pelvis = data.body("pelvis")
    place = pelvis.xpos + pelvis.xmat.reshape(3, 3) @ [0, 0, 0.05]
    assert np.linalg.norm(data.geom_xpos - place, axis=1).min() < 1e-12


def test_what_shows_nothing_gets_sticks(bare_robot: Callable[..., Robot]) -> None:
    robot = bare_robot(lambda text: re.sub(r"<visual>.*?</visual>", "", text, flags=re.DOTALL))
    model = load_picture_scene(robot)
    kinds = list(model.geom_type)
    assert kinds.count(mujoco.mjtGeom.mjGEOM_CAPSULE) > 5
    # and its soles are seen
    assert (
        model.geom_group[[model.geom(name).id for name in ("left_foot", "right_foot")]] == 0
    ).all()


def test_a_missing_mesh_is_left_out_of_the_picture(bare_robot: Callable[..., Robot]) -> None:
    robot = bare_robot(_with_mesh("package://nowhere/pelvis.stl"))
    spec = build_scene(robot)
    assert add_visuals(spec, robot) == ("package://nowhere/pelvis.stl",)
    whole = load_picture_scene(bare_robot())
    assert spec.compile().ngeom == whole.ngeom - 1


def test_a_mesh_is_drawn_open_mirrored_and_with_lines_among_its_faces(
    bare_robot: Callable[..., Robot], tmp_path: Path
) -> None:
    (tmp_path / "hermes_lower" / "roof.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5\nf 1 2 3\nf 2 4 3\nf 1 1 2\n"
    )
    edit = _with_mesh("roof.obj")
    robot = bare_robot(lambda text: edit(text).replace("roof.obj", 'roof.obj" scale="1 -1 1'))
    model = load_picture_scene(robot)
    assert model.nmeshface == 2
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    (roof,) = np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_MESH)
    normals = model.mesh_normal @ data.geom_xmat[roof].reshape(3, 3).T
    assert normals[:, 2].min() > 0  # outside is still above


def test_a_mesh_that_cannot_be_read_is_told(
    bare_robot: Callable[..., Robot], tmp_path: Path
) -> None:
    robot = bare_robot(_with_mesh("broken.stl"))
    (robot.source_path.parent / "broken.stl").write_text("no mesh")
    with pytest.raises(RobotFileError, match="mesh that cannot be read"):
        load_picture_scene(robot)
    with pytest.raises(RobotFileError, match="mesh that cannot be read"):
        render_postures(robot, robot.home.q[None, :], 60, 80)


def test_a_library_that_does_not_work_costs_no_more_than_the_picture(
    robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gl_library, "LIBRARIES", ("none",))
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    assert render_postures(robot, robot.home.q[None, :]) is None


@pytest.mark.parametrize(
    ("chosen", "tried"),
    [("", gl_library.LIBRARIES), ("disable", gl_library.LIBRARIES), ("a", ("a", "egl", "osmesa"))],
)
def test_the_users_library_is_tried_first(
    robot: Robot, monkeypatch: pytest.MonkeyPatch, chosen: str, tried: tuple[str, ...]
) -> None:
    libraries: list[str] = []
    monkeypatch.setenv("MUJOCO_GL", chosen)
    monkeypatch.setattr(rendering, "_render_apart", lambda library, *_: libraries.append(library))
    assert render_postures(robot, robot.home.q[None, :]) is None
    assert tuple(libraries) == tried
