"""The robot's part of a film, picture by picture, from a process of its own."""

from __future__ import annotations

import select
import subprocess
import sys
import tempfile
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import IO

import numpy as np

from tsd_casadi.exceptions import NotAvailable, RobotFileError
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix
from tsd_clients.film.gl_library import REFUSED, environment_with, libraries
from tsd_clients.film.video_file import Picture

# how long a picture may take, the first one with loading the meshes of the robot [s]
PATIENCE = 120.0


def robot_frames(
    robot: Robot, q: Matrix, ghosts: Matrix, arrows: Matrix, width: int, height: int
) -> Generator[Picture, None, None]:
    """Draw a robot, its ghost and its contact forces.

    Args:
        q: (N, nq), Pinocchio's convention.
        ghosts: (N, nq), of the translucent robot.
        arrows: (N, c, 2, 3) [m], world frame.
        width: [pixels].
        height: [pixels].

    Yields:
        N pictures, (height, width, 3).

    Raises:
        NotAvailable: If no GL library works.
        RobotFileError: If the robot cannot be drawn.
    """
    with tempfile.TemporaryDirectory(prefix="tsd-film-") as folder:
        request = Path(folder) / "request.npz"
        np.savez(request, q=q, ghosts=ghosts, arrows=arrows)
        for library in libraries():
            drawn = 0
            for picture in _frames_by(library, robot, request, width, height):
                yield picture
                drawn += 1
            if drawn == len(q):
                return
            if drawn:
                break  # it works, and did not go on: another one cannot take over
    raise NotAvailable(
        "a film",
        "a GL library for offscreen rendering",
        "'apt install libosmesa6' (or libegl1) provides one",
    )


def _frames_by(
    library: str, robot: Robot, request: Path, width: int, height: int
) -> Iterator[Picture]:
    """Draw with one library; stops where it does not work.

    Raises:
        RobotFileError: If the robot cannot be drawn, with any library.
    """
    command = [sys.executable, "-m", "tsd_clients.film.frame_drawing", str(robot.path)]
    command += [str(request), str(width), str(height)]
    with (
        tempfile.TemporaryFile() as told,
        subprocess.Popen(
            command, env=environment_with(library), stdout=subprocess.PIPE, stderr=told, bufsize=0
        ) as process,
    ):
        assert process.stdout is not None
        try:
            while (data := _read(process.stdout, 3 * width * height)) is not None:
                yield np.frombuffer(data, dtype=np.uint8).reshape(height, width, 3)
        finally:
            if process.poll() is None:
                try:
                    # it has ended its work, or is not wanted any more
                    process.wait(0.0 if data is not None else 5.0)
                except subprocess.TimeoutExpired:
                    process.kill()
        if process.wait() == REFUSED:
            told.seek(0)
            message = told.read().decode(errors="replace").strip()
            raise RobotFileError.of_message(message)


def _read(pipe: IO[bytes], size: int) -> bytearray | None:
    """Read a whole picture; None if the other side ended or is silent."""
    data = bytearray()
    while len(data) < size:
        ready, _, _ = select.select([pipe], [], [], PATIENCE)
        part = pipe.read(size - len(data)) if ready else b""
        if not part:
            return None
        data += part
    return data
