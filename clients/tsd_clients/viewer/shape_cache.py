"""Shapes of robots, made by a process of their own and kept.

Reading the meshes of a humanoid takes seconds in one call that no other thread gets past:
the page would stand still.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np

from tsd_casadi.compilation.code_cache import cache_folder
from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_casadi.whole_file import write_whole
from tsd_clients.viewer.robot_shapes import BUDGET, Shape, robot_shapes

# of the file; another one is another name
VERSION = 1


def shapes_file(robot: Robot) -> Path:
    """Name the file of a robot's shapes."""
    parts = (str(VERSION), str(BUDGET), robot.fingerprint, str(robot.source_path))
    digest = hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]
    return cache_folder() / "shapes" / f"{robot.name}-{digest}.npz"


class ShapesOfRobot:
    """Shapes that are there at once or soon."""

    def __init__(self, robot: Robot) -> None:
        """Start to make them if nobody did before."""
        self._path = shapes_file(robot)
        self._process: subprocess.Popen[bytes] | None = None
        if not self._path.is_file():
            self._process = subprocess.Popen(
                [sys.executable, "-m", "tsd_clients.viewer.shape_cache", str(robot.path)],
                stderr=subprocess.PIPE,
            )

    def take(self) -> list[Shape] | None:
        """Read them; None while they are being made.

        Raises:
            RobotFileError: If they cannot be made.
        """
        if self._process is not None:
            if self._process.poll() is None:
                return None
            _, said = self._process.communicate()
            if self._process.returncode or not self._path.is_file():
                lines = said.decode(errors="replace").strip().splitlines()
                raise RobotFileError.of_message(lines[-1] if lines else "no shapes were made")
        return read_shapes(self._path)

    def close(self) -> None:
        """End what makes them."""
        if self._process is not None and self._process.poll() is None:
            self._process.kill()
            self._process.communicate()


def write_shapes(shapes: list[Shape], path: Path) -> None:
    """Write shapes."""
    arrays: dict[str, np.ndarray] = {}
    for number, shape in enumerate(shapes):
        arrays[f"vertices{number}"] = shape.vertices.astype(np.float32)
        arrays[f"faces{number}"] = shape.faces.astype(np.uint32)
    joints = np.array([shape.joint for shape in shapes], dtype=int)
    colors = np.array([shape.color for shape in shapes]).reshape(-1, 3)
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    with write_whole(path) as file:
        np.savez(file, joints=joints, colors=colors, **arrays)  # type: ignore[arg-type]


def read_shapes(path: Path) -> list[Shape]:
    """Read what ``write_shapes`` wrote."""
    with np.load(path, allow_pickle=False) as saved:
        return [
            Shape(
                int(joint),
                saved[f"vertices{number}"].astype(float),
                saved[f"faces{number}"].astype(np.int64),
                (float(color[0]), float(color[1]), float(color[2])),
            )
            for number, (joint, color) in enumerate(
                zip(saved["joints"], saved["colors"], strict=True)
            )
        ]


if __name__ == "__main__":
    named = load_robot(sys.argv[1])
    write_shapes(robot_shapes(named), shapes_file(named))
