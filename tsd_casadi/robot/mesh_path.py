"""Where the mesh files are that a description names, without ROS."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote

from tsd_casadi.robot.description_path import find_package

# both name a package first, as ROS and Gazebo write it
PACKAGES = ("package://", "model://")
FILE = "file://"


def find_mesh(description: Path, written: str) -> Path | None:
    """Find a mesh file.

    A package is looked for among the folders that the description is in, then
    where data packages are installed and where ROS's variables point.

    Args:
        description: The file that names it.
        written: As it stands there: package://, model:// or file:// and a path, or a
            path relative to the description.

    Returns:
        The file, None if it is not there.
    """
    for scheme in PACKAGES:
        if written.startswith(scheme):
            rest = unquote(written.removeprefix(scheme)).strip("/")
            return next((path for path in _in_package(description, rest) if path.is_file()), None)
    path = description.parent / unquote(written.removeprefix(FILE))
    return path if path.is_file() else None


def _in_package(description: Path, rest: str) -> list[Path]:
    name, _, inside = rest.partition("/")
    # the package's folder may be called otherwise, as a repository often is
    parents = list(description.resolve().parents)
    places = [parent / rest for parent in parents]
    places += [parent / inside for parent in parents if (parent / "package.xml").is_file()]
    package = find_package(name)
    return places if package is None else [*places, package / inside]
