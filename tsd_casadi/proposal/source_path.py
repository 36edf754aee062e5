"""How a robot file names its description: inside its folder, or in a data package."""

from __future__ import annotations

from pathlib import Path

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.description_path import PACKAGE, find_package


def path_in_file(source: Path, robot_file: Path) -> str:
    """Name a description in a robot file.

    Returns:
        A path relative to the robot file, or 'package://name/path'.

    Raises:
        RobotFileError: If it is neither in the robot file's folder nor in a package.
    """
    source, folder = source.resolve(), robot_file.resolve().parent
    if source.is_relative_to(folder):
        return source.relative_to(folder).as_posix()
    package = package_of(source)
    if package is not None:
        return f"{PACKAGE}{package.name}/{source.relative_to(package).as_posix()}"
    raise RobotFileError(
        robot_file,
        "",
        f"is to be written where '{source}' is not below it",
        f"a robot file beside its description or above it: --out {source.parent / robot_file.name}",
    )


def package_of(source: Path) -> Path | None:
    """Find the installed data package that a file is in, None if it is in none."""
    for folder in source.resolve().parents:
        found = find_package(folder.name)
        if found is not None and found.resolve() == folder:
            return folder
    return None
