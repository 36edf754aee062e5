"""Draws postures offscreen; a program of its own, for the GL library is chosen once."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from tsd_casadi.exceptions import TsdError
from tsd_casadi.robot.robot import load_robot
from tsd_casadi.state import State
from tsd_clients.film.camera import camera_at_home
from tsd_clients.film.gl_library import REFUSED
from tsd_clients.film.picture_scene import load_picture_scene
from tsd_clients.simulator.state_map import StateMap

# GL without a graphics card draws shadows of 4096 x 4096 for seconds [pixels]
SHADOW = 1024


def draw_postures(
    robot_path: Path, postures: Path, target: Path, width: int, height: int, azimuth: float | None
) -> None:
    """Draw a robot's postures with one camera at rest.

    Args:
        robot_path: The robot file.
        postures: NumPy's file of (N, nq), Pinocchio's convention.
        target: NumPy's file of the frames, to be written, (N, height, width, 3).
        width: [pixels].
        height: [pixels].
        azimuth: Of where the camera looks [deg], the scene's where None.
    """
    robot = load_robot(robot_path)
    model: Any = load_picture_scene(robot)
    # scenes say how large their pictures are at most, 640 x 480 by default
    model.vis.global_.offwidth = max(model.vis.global_.offwidth, width)
    model.vis.global_.offheight = max(model.vis.global_.offheight, height)
    model.vis.quality.shadowsize = SHADOW
    data = mujoco.MjData(model)
    state_map = StateMap(robot, model)
    frames = []
    with mujoco.Renderer(model, height, width) as renderer:
        camera = camera_at_home(robot, model, data, state_map, azimuth)
        for q in np.load(postures):
            state_map.write(data, State(q, np.zeros(robot.nv)))
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, camera)
            frames.append(renderer.render().copy())
    np.save(target, np.array(frames))


if __name__ == "__main__":
    robot_file, given_file, target_file = map(Path, sys.argv[1:4])
    pixels = int(sys.argv[4]), int(sys.argv[5])
    seen_from = float(sys.argv[6]) if sys.argv[6] else None
    try:
        draw_postures(robot_file, given_file, target_file, *pixels, seen_from)
    except TsdError as error:
        print(error, file=sys.stderr)
        sys.exit(REFUSED)
