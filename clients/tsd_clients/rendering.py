"""Pictures of the simulated robot, rendered without a screen.

MuJoCo chooses its GL library when it is imported, so each library is tried in
a process of its own; a missing or broken one then costs a picture and nothing
else.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from tsd_casadi.robot import Robot
from tsd_clients.run import Run

LIBRARIES = ("egl", "osmesa")
HINT = (
    "No picture of the robot: no GL library for offscreen rendering was found; "
    "'apt install libosmesa6' (or libegl1) provides one."
)
WIDTH, HEIGHT = 480, 640


def render_squat(robot: Robot, run: Run, out: Path) -> str:
    """Render the top and the bottom of the last lap, side by side.

    Args:
        robot: The robot.
        run: The run to take the postures from.
        out: Folder for squat.png.

    Returns:
        A sentence that says where the picture is, or what is missing.
    """
    target = out / "squat.png"
    height = np.where(run.log["measured"], run.log["reference"], np.nan)
    moments = [int(np.nanargmax(height)), int(np.nanargmin(height))]
    with tempfile.TemporaryDirectory(prefix="tsd-render-") as folder:
        postures = Path(folder) / "postures.npy"
        np.save(postures, run.log["q"][moments].astype(float))
        for library in (os.environ.get("MUJOCO_GL"), *LIBRARIES):
            if library and _render_apart(library, robot.path, postures, target):
                return f"Picture of the squat: {target}."
    return HINT


def _render_apart(library: str, robot: Path, postures: Path, target: Path) -> bool:
    arguments = [str(robot), str(postures), str(target)]
    command = [sys.executable, "-m", "tsd_clients.rendering", *arguments]
    environment = {**os.environ, "MUJOCO_GL": library}
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, timeout=60, check=False
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0 and target.is_file()


def _render(robot_path: Path, postures: Path, target: Path) -> None:
    import mujoco
    from matplotlib.image import imsave

    from tsd_casadi import State, load_robot
    from tsd_clients.mujoco_state import StateMap

    robot = load_robot(robot_path)
    model: Any = mujoco.MjModel.from_xml_path(str(robot.scene_path))
    data = mujoco.MjData(model)
    state_map = StateMap(robot, model)
    frames = []
    with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
        camera = mujoco.MjvCamera()
        mujoco.mjv_defaultFreeCamera(model, camera)
        camera.distance = 3.0 * float(robot.home_com[2])
        for q in np.load(postures):
            state_map.write(data, State(q, np.zeros(robot.nv)))
            mujoco.mj_forward(model, data)
            camera.lookat[:] = (q[0], q[1], 0.75 * float(robot.home_com[2]))
            renderer.update_scene(data, camera)
            frames.append(renderer.render().copy())
    imsave(target, np.concatenate(frames, axis=1))


if __name__ == "__main__":
    _render(Path(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3]))
