"""The camera of all pictures: at rest, it sees where the robot stands at home."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from tsd_casadi.robot.robot import Robot
from tsd_clients.simulator.state_map import StateMap


def camera_at_home(
    robot: Robot, model: Any, data: Any, state_map: StateMap, azimuth: float | None
) -> Any:
    """Make the camera.

    Args:
        model: ``mujoco.MjModel`` of the picture's scene.
        data: ``mujoco.MjData``, put into the home posture.
        azimuth: Of where the camera looks [deg], the scene's where None.

    Returns:
        ``mujoco.MjvCamera``.
    """
    camera = mujoco.MjvCamera()
    mujoco.mjv_defaultFreeCamera(model, camera)
    if azimuth is not None:
        camera.azimuth = azimuth
    state_map.write(data, robot.home)
    mujoco.mj_kinematics(model, data)
    com, top = robot.home_com, _top(model, data)
    camera.distance = max(3.0 * com[2], 1.6 * top)
    # a camera that followed the robot would hide its motion
    camera.lookat[:] = (com[0], com[1], max(0.75 * com[2], 0.5 * top))
    return camera


def _top(model: Any, data: Any) -> float:
    """Find how high the robot's shapes reach [m]."""
    robots = np.flatnonzero(model.body_weldid[model.geom_bodyid])
    axes = data.geom_xmat[robots].reshape(-1, 3, 3)
    center, half = model.geom_aabb[robots, :3], model.geom_aabb[robots, 3:]
    up = axes[:, 2]
    tops = data.geom_xpos[robots, 2] + (up * center + np.abs(up) * half).sum(axis=1)
    return float(tops.max(initial=0.0))
