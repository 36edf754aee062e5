"""Where the files are that a robot file names: beside it, or in an installed data package."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from tsd_casadi.exceptions import RobotFileError

PACKAGE = "package://"


def resolve_path(robot_file: Path, field: str, text: str) -> Path:
    """Find a file that a robot file names.

    Args:
        field: Where it is named, for the error.
        text: A path relative to the robot file, or 'package://name/path'.

    Raises:
        RobotFileError: If there is no such file, or it is outside the robot file's
            folder and of no package: who sends a robot sends its folder.
    """
    if text.startswith(PACKAGE):
        name, _, rest = text.removeprefix(PACKAGE).partition("/")
        folder = find_package(name)
        if folder is None:
            raise RobotFileError(
                robot_file,
                field,
                f"names the package '{name}', which is not installed",
                f"its data: 'pip install {name}' brings those that are on PyPI (of the robots that "
                "come with this project: pip install '.[robots]' in the project's folder), a "
                "folder of ROS packages is found by ROS_PACKAGE_PATH",
            )
        path = folder / rest
    else:
        folder = robot_file.parent
        path = folder / text
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError):  # too long, or a zero byte
        inside = True
    if not inside:
        raise RobotFileError(
            robot_file,
            field,
            f"'{text}' leaves the folder {folder}",
            "a path inside the robot file's folder, or package://name/path",
        )
    if not os.path.isfile(path):  # a path's own is_file refuses long names
        raise RobotFileError(
            robot_file, field, f"'{path}' is no file", "a path relative to this file"
        )
    return path


def find_package(name: str) -> Path | None:
    """Find the folder of a data package, without ROS.

    Looked at are the data folders of Python's environments, where for instance
    example-robot-data puts its own, and those that ROS_PACKAGE_PATH and
    AMENT_PREFIX_PATH name.

    Returns:
        The folder called like that, None if there is none.
    """
    if not name or name in (".", "..") or "/" in name:
        return None
    shares = [Path(entry) / "cmeel.prefix" / "share" for entry in sys.path]
    shares += [Path(sys.prefix) / "share"]
    shares += [Path(entry) for entry in _listed("ROS_PACKAGE_PATH")]
    shares += [Path(entry) / "share" for entry in _listed("AMENT_PREFIX_PATH")]
    return next((share / name for share in shares if (share / name).is_dir()), None)


def _listed(variable: str) -> list[str]:
    return [entry for entry in os.environ.get(variable, "").split(os.pathsep) if entry]
