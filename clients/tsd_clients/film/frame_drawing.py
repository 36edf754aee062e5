"""Draws the robot's part of a film; a program of its own, for the GL library is chosen once.

Writes each picture to stdout as it is drawn, (height, width, 3) of bytes.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from PIL import Image

from tsd_casadi.exceptions import TsdError
from tsd_casadi.robot.robot import load_robot
from tsd_casadi.state import State
from tsd_clients.film.arrow_overlay import draw_arrows, project
from tsd_clients.film.camera import camera_at_home
from tsd_clients.film.gl_library import REFUSED
from tsd_clients.film.picture_scene import load_picture_scene
from tsd_clients.film.video_file import Picture
from tsd_clients.simulator.state_map import StateMap

# a humanoid of fifty meshes is drawn 50 times a second then, and nobody sees a difference
MOST_FACES = 1000
# drawn so much larger and averaged: MuJoCo's own smoothing is ten times slower without a GPU
FINER = 2
GHOST = np.array([0.95, 0.55, 0.10, 0.45], dtype=np.float32)
# how far behind its place the ghost is drawn, of the centre of mass' height at home:
# where it and the robot are at the same place, the robot is seen
BEHIND = 0.03
SLOW_EFFECTS = (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION)


def draw_frames(robot_path: Path, request: Path, width: int, height: int) -> Iterator[Picture]:
    """Draw what a film shows of the robot.

    Args:
        robot_path: The robot file.
        request: NumPy's file with 'q' and 'ghosts', (N, nq), and 'arrows', (N, c, 2, 3).
        width: [pixels].
        height: [pixels].

    Yields:
        Pictures, (height, width, 3).
    """
    robot = load_robot(robot_path)
    model: Any = load_picture_scene(robot, MOST_FACES)
    size = FINER * width, FINER * height
    model.vis.global_.offwidth, model.vis.global_.offheight = size
    model.vis.quality.offsamples = 0
    data, ghost_data = mujoco.MjData(model), mujoco.MjData(model)
    state_map, rest = StateMap(robot, model), np.zeros(robot.nv)
    behind = BEHIND * float(robot.home_com[2])
    with mujoco.Renderer(model, size[1], size[0]) as renderer, np.load(request) as asked:
        camera, scene = camera_at_home(robot, model, data, state_map, None), renderer.scene
        for q, ghost, arrows in zip(asked["q"], asked["ghosts"], asked["arrows"], strict=True):
            state_map.write(data, State(q, rest))
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, camera)
            for effect in SLOW_EFFECTS:
                scene.flags[effect] = 0
            state_map.write(ghost_data, State(ghost, rest))
            mujoco.mj_forward(model, ghost_data)
            _add_ghost(model, ghost_data, scene, behind)
            picture = np.asarray(Image.fromarray(renderer.render()).reduce(FINER))
            yield draw_arrows(picture, project(scene, arrows, width, height))


def _add_ghost(model: Any, data: Any, scene: Any, behind: float) -> None:
    """Add the robot in another posture, translucent."""
    first, away = scene.ngeom, behind * np.array(scene.camera[0].forward)
    everything, moved = mujoco.MjvOption(), mujoco.MjvPerturb()
    dynamic = mujoco.mjtCatBit.mjCAT_DYNAMIC
    mujoco.mjv_addGeoms(model, data, everything, moved, dynamic, scene)
    for geom in scene.geoms[first : scene.ngeom]:
        geom.rgba[:] = GHOST
        geom.matid = -1
        geom.pos[:] += away


if __name__ == "__main__":
    # what libraries print is none of the pictures
    pictures = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    robot_file, request_file = Path(sys.argv[1]), Path(sys.argv[2])
    try:
        for drawn in draw_frames(robot_file, request_file, int(sys.argv[3]), int(sys.argv[4])):
            pictures.write(drawn.tobytes())
            pictures.flush()
    except TsdError as error:
        print(error, file=sys.stderr)
        sys.exit(REFUSED)
