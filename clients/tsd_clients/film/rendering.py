"""Pictures of the simulated robot, rendered without a screen."""

from __future__ import annotations

import io
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix
from tsd_clients.film.gl_library import HINT, REFUSED, environment_with, libraries
from tsd_clients.film.video_file import GifFile

Pictures = NDArray[np.uint8]

WIDTH, HEIGHT = 480, 640
# how long rendering may take: its start, and each picture
PATIENCE, PATIENCE_PER_PICTURE = 60.0, 2.0  # s


def render_extremes(robot: Robot, run: Run, out: Path) -> str:
    """Render where the first axis is highest and lowest in the measured laps, side by side.

    Args:
        out: Folder for the picture, which has the motion's name.

    Returns:
        A sentence that says where the picture is, or what is missing.
    """
    from matplotlib.image import imsave

    place = np.where(run.log["measured"], run.along("reference", run.axes[0]), np.nan)
    moments = [int(np.nanargmax(place)), int(np.nanargmin(place))]
    frames = render_postures(robot, run.log["q"][moments])
    if frames is None:
        return HINT
    target = out / f"{run.motion.name}.png"
    imsave(target, side_by_side(frames))
    return f"Picture of the {run.motion.name}: {target}."


def render_postures(
    robot: Robot,
    postures: Matrix,
    width: int = WIDTH,
    height: int = HEIGHT,
    azimuth: float | None = None,
) -> Pictures | None:
    """Render postures with one camera at rest.

    Args:
        postures: (N, nq), Pinocchio's convention.
        width: [pixels].
        height: [pixels].
        azimuth: Of where the camera looks [deg], 180 sees the robot from in front;
            that of the robot's scene by default.

    Returns:
        (N, height, width, 3) of bytes; None if no GL library works, see ``HINT``.

    Raises:
        RobotFileError: If the robot cannot be drawn: its scene, or a mesh that is there.
    """
    with tempfile.TemporaryDirectory(prefix="tsd-render-") as folder:
        given, target = Path(folder) / "postures.npy", Path(folder) / "frames.npy"
        seen_from = "" if azimuth is None else str(azimuth)
        np.save(given, np.asarray(postures, dtype=float))
        for library in libraries():
            if _render_apart(
                library,
                [str(robot.path), str(given), str(target), str(width), str(height), seen_from],
                PATIENCE + PATIENCE_PER_PICTURE * len(postures),
            ):
                return np.asarray(np.load(target))
    return None


def side_by_side(frames: Pictures) -> Pictures:
    """Put several pictures side by side.

    Args:
        frames: (N, height, width, 3).

    Returns:
        (height, N * width, 3).
    """
    return np.concatenate(list(frames), axis=1)


def animate(frames: Pictures, seconds: float) -> bytes:
    """Make a GIF that repeats for ever.

    Args:
        frames: (N, height, width, 3) of bytes.
        seconds: How long all of them take; GIF knows hundredths of a second.
    """
    buffer = io.BytesIO()
    gif = GifFile(buffer, len(frames) / seconds)
    for frame in frames:
        gif.add(frame)
    gif.close()
    return buffer.getvalue()


def _render_apart(library: str, arguments: list[str], patience: float) -> bool:
    """Draw in a process of its own; False where the library does not work.

    Raises:
        RobotFileError: If the robot cannot be drawn, with any library.
    """
    command = [sys.executable, "-m", "tsd_clients.film.drawing", *arguments]
    environment = environment_with(library)
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, timeout=patience, check=False
        )
    except subprocess.TimeoutExpired:
        return False
    if done.returncode == REFUSED:
        raise RobotFileError.of_message(done.stderr.decode(errors="replace").strip())
    return done.returncode == 0
