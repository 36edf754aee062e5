"""The MuJoCo model of a robot: its scene where it has one, else one made in memory."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.robot import Robot
from tsd_clients.simulator.build_scene import build_scene


def load_scene(robot: Robot) -> Any:
    """Load the robot's scene, or build one if its file names none.

    Returns:
        ``mujoco.MjModel``.

    Raises:
        RobotFileError: If the scene cannot be loaded, or the robot not be simulated.
    """
    try:
        if robot.scene_path is None:
            return build_scene(robot).compile()
        return mujoco.MjModel.from_xml_path(str(robot.scene_path))
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise RobotFileError(
            scene_file(robot), "", f"cannot be loaded ({reason})", "a robot that MuJoCo takes"
        ) from error


def scene_file(robot: Robot) -> Path:
    """Tell which file a mistake in the scene is in: the robot's own where none is named."""
    return robot.scene_path or robot.path
