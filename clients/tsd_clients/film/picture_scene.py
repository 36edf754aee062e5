"""The scene of a picture: the robot's own, or one made with everything that it shows."""

from __future__ import annotations

from typing import Any

import mujoco

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.robot import Robot
from tsd_clients.film.visual_geoms import add_visuals
from tsd_clients.simulator.build_scene import build_scene
from tsd_clients.simulator.ground import FLOOR
from tsd_clients.simulator.scene import load_scene

SKY = ((0.93, 0.95, 0.97), (0.75, 0.80, 0.86))
TILES = ((0.80, 0.82, 0.84), (0.72, 0.74, 0.77))
PIXELS = 256  # of a texture's edge
REPEAT = 1.0  # tiles, two by two, per metre
HEADLIGHT = {"diffuse": 0.6, "ambient": 0.35, "specular": 0.0}
LAMP = {"pos": (1.5, -1.5, 3.0), "dir": (-0.4, 0.4, -1.0), "diffuse": (0.5, 0.5, 0.5)}
AZIMUTH, ELEVATION = 130.0, -12.0  # deg


def load_picture_scene(robot: Robot, most_faces: int | None = None) -> Any:
    """Load what a picture of the robot is taken of.

    Args:
        most_faces: Of each of the description's meshes; larger ones are simplified.

    Returns:
        ``mujoco.MjModel``: the robot's scene, or where it has none the one that a
        simulation would use, with the description's visual shapes.

    Raises:
        RobotFileError: If the scene or a mesh that is there cannot be used.
    """
    if robot.scene_path is not None:
        return load_scene(robot)
    spec = build_scene(robot)
    add_visuals(spec, robot, most_faces)
    _add_surroundings(spec)
    try:
        return spec.compile()
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise RobotFileError(
            robot.source_path, "", f"cannot be drawn ({reason})", "shapes that MuJoCo takes"
        ) from error


def _add_surroundings(spec: Any) -> None:
    """Add sky, tiles and light: without them a picture is black and without a scale."""
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=SKY[0],
        rgb2=SKY[1],
        width=PIXELS,
        height=6 * PIXELS,
    )
    spec.add_texture(
        name=FLOOR,
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=TILES[0],
        rgb2=TILES[1],
        width=PIXELS,
        height=PIXELS,
    )
    tiles = spec.add_material(name=FLOOR, texrepeat=(REPEAT, REPEAT), texuniform=True)
    tiles.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = FLOOR
    floor = spec.geom(FLOOR)
    floor.material, floor.rgba = FLOOR, (1.0, 1.0, 1.0, 1.0)
    spec.worldbody.add_light(**LAMP)
    for name, value in HEADLIGHT.items():
        getattr(spec.visual.headlight, name)[:] = value
    look = spec.visual.global_
    look.azimuth, look.elevation = AZIMUTH, ELEVATION
