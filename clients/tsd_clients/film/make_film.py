"""A film: the robot with its ghost, and beside it what its controller did."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.robot.robot import Robot
from tsd_casadi.whole_file import write_whole
from tsd_clients.film.clip import Clip
from tsd_clients.film.robot_frames import robot_frames
from tsd_clients.film.strip_charts import StripCharts
from tsd_clients.film.video_file import Picture, check_film_path, open_video

SIZE = (640, 480)  # pixels
# smaller ones show no writing, larger ones take minutes [pixels]
LEAST, MOST = (240, 180), (1920, 1080)
HEADER, ROBOT = 0.11, 0.42  # of the height and of the width
TITLE, CAPTION = 0.36, 0.30  # of the header's height
PAPER, INK, FAINT = (255, 255, 255), (30, 30, 30), (90, 90, 90)
LEGEND = (("reference", (230, 130, 25)), ("contact forces", (20, 140, 60)))

Progress = Callable[[float, float], None]


def check_size(size: tuple[int, int]) -> None:
    """Refuse sizes of a film that cannot be.

    Raises:
        InvalidValue: If width or height is odd or out of range.
    """
    names = ("width", "height")
    for name, value, least, most in zip(names, size, LEAST, MOST, strict=True):
        if value % 2 or not least <= value <= most:
            raise InvalidValue(f"film {name}", value, f"{least} to {most} pixels, even")


def make_film(
    robot: Robot,
    clips: Sequence[Clip],
    path: str | Path,
    title: str,
    size: tuple[int, int] = SIZE,
    progress: Progress | None = None,
) -> None:
    """Make a film of some repetitions, one after another.

    Args:
        clips: At least one; with the same axes, and the rate of ``rate_of(path)``.
        path: Ends in .mp4 or .gif; written whole or not at all.
        size: Width and height, even [pixels].
        progress: Called with (done, total) pictures.

    Raises:
        InvalidValue: If path or size cannot be used.
        NotAvailable: If the libraries for it are not there.
        RobotFileError: If the robot cannot be drawn.
    """
    check_size(size)
    check_film_path(path)
    total = sum(len(clip.time) for clip in clips)
    with write_whole(path) as file:
        video = open_video(file, path, *size)
        for done, picture in enumerate(_pictures(robot, clips, title, size)):
            video.add(picture)
            if progress is not None:
                progress(done + 1, total)
        video.close()


def _pictures(
    robot: Robot, clips: Sequence[Clip], title: str, size: tuple[int, int]
) -> Iterator[Picture]:
    width, height = size
    header = round(HEADER * height)
    robot_width = round(ROBOT * width)
    charts = StripCharts(clips, width - robot_width, height - header)
    q, ghosts, arrows = (
        np.concatenate([getattr(clip, name) for clip in clips])
        for name in ("q", "ghosts", "arrows")
    )
    start = 0.0
    frames = robot_frames(robot, q, ghosts, arrows, robot_width, height - header)
    with closing(frames):
        for clip in clips:
            for place, (time, lap) in enumerate(zip(clip.time, clip.lap, strict=True)):
                now = start + (place + 1) / clip.rate
                beside = np.concatenate((next(frames), charts.at(now)), axis=1)
                above = _header(title, _caption(clip, time, lap), width, header)
                yield _with_legend(np.concatenate((above, beside), axis=0), header)
            start += clip.seconds


def _caption(clip: Clip, time: float, lap: int) -> str:
    parts = [clip.label, "holding" if lap < 0 else f"lap {lap + 1}", f"{time:.1f} s"]
    if np.isfinite(clip.rms[0]):
        axis = clip.axes[0]
        parts.append(f"error {axis} {1e3 * clip.rms[0]:.3g} m{unit_of_axis(axis)} RMS")
    return "   ".join(part for part in parts if part)


def _header(title: str, caption: str, width: int, height: int) -> Picture:
    from PIL import Image, ImageDraw

    image = Image.new("RGB", (width, height), PAPER)
    draw = ImageDraw.Draw(image)
    left = height // 5
    draw.text((left, height // 9), title, INK, _font(TITLE * height, "-Bold"))
    draw.text((left, round(0.56 * height)), caption, FAINT, _font(CAPTION * height))
    return np.asarray(image)


def _with_legend(picture: Picture, header: int) -> Picture:
    """Say what ghost and arrows are, below on the left."""
    from PIL import Image, ImageDraw

    image = Image.fromarray(picture)
    draw = ImageDraw.Draw(image)
    font = _font(0.26 * header)
    line = round(0.36 * header)
    for number, (text, color) in enumerate(LEGEND):
        top = image.height - (len(LEGEND) - number) * line - line // 4
        draw.rectangle((header // 5, top, header // 5 + line // 2, top + line // 2), fill=color)
        place = header // 5 + line, top - line // 6
        # legible on dark ground and on light
        draw.text(place, text, PAPER, font, stroke_width=1, stroke_fill=FAINT)
    return np.asarray(image)


@cache
def _font(size: float, weight: str = "") -> Any:
    import matplotlib
    from PIL import ImageFont

    path = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / f"DejaVuSans{weight}.ttf"
    return ImageFont.truetype(str(path), round(size))
