"""Looking at runs: films of them, and MuJoCo's viewer while they go on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.observer import Observer
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_cli.actions.label import describe_motion
from tsd_cli.interrupt import interruptible
from tsd_cli.options.film import FilmOptions, FilmSizeOptions
from tsd_cli.options.robot import RobotOptions
from tsd_clients.console.progress import show_progress
from tsd_clients.film.clip import Clip, last_lap, make_clip
from tsd_clients.film.make_film import check_size, make_film
from tsd_clients.film.video_file import check_film_path, rate_of
from tsd_clients.logs.log import Log
from tsd_clients.logs.read_log import read_log


class Footage:
    """What of some runs goes into a film; nothing where none was asked for."""

    def __init__(self, options: FilmOptions, robot: Robot) -> None:
        """Check what was asked for, before the work.

        Raises:
            InvalidValue: If the film's name or size cannot be.
            NotAvailable: If what makes films, or a desktop for the viewer, is not there.
        """
        self._path, self._robot = options.video, robot
        self._clips: list[Clip] = []
        self._title = ""
        if self._path is not None:
            check_film_path(self._path)
            self._size = read_size(options)
        if options.viewer:
            from tsd_clients.film.desktop_viewer import check_display

            check_display()

    def keep(self, run: Run) -> None:
        """Take all of a run."""
        self._keep(run, run.log, "")

    def keep_last_lap(self, run: Run) -> None:
        """Take the last lap of one of several runs."""
        self._keep(run, last_lap(run.log), f"iteration {run.feedforward.iteration or 0}")

    def _keep(self, run: Run, fields: dict[str, Any], label: str) -> None:
        if self._path is None:
            return
        self._title = title_of(run)
        self._clips.append(
            make_clip(
                self._robot,
                fields,
                run.axes,
                rate=rate_of(self._path),
                label=label,
                plotted=len(run.learned),
            )
        )

    def make(self) -> None:
        """Make the film, if one was asked for and there is something to show.

        Raises:
            TsdError: If it cannot be made.
        """
        if self._path is not None and self._clips:
            _make(self._robot, self._clips, self._path, self._title, self._size)


def title_of(run: Run) -> str:
    """Say what a film is of: 'robot: squat 3 cm, model error 10 %, P x 0.2'."""
    settings = run.settings
    parts = [describe_motion(run.motion)]
    if error := settings.get("model_error"):
        parts.append(f"model error {100 * error:g} %")
    if settings.get("hardware"):
        parts.append("hardware")
    if settings["p_scale"] != 1.0:
        parts.append(f"P x {settings['p_scale']:g}")
    return f"{run.robot}: {', '.join(parts)}"


def read_size(options: FilmSizeOptions) -> tuple[int, int]:
    """Read the size of a film.

    Raises:
        InvalidValue: If it is none.
    """
    width, _, height = options.video_size.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise InvalidValue("--video-size", f"'{options.video_size}'", "WIDTHxHEIGHT, as 640x480")
    size = int(width), int(height)
    check_size(size)
    return size


@contextmanager
def open_viewer(options: FilmOptions, robot: Robot) -> Iterator[Observer | None]:
    """Open MuJoCo's viewer if it was asked for; gives who watches, None where nobody does.

    Raises:
        NotAvailable: If there is no desktop.
    """
    if not options.viewer:
        yield None
        return
    from tsd_clients.film.desktop_viewer import open_desktop_viewer

    with open_desktop_viewer(robot) as viewer:
        yield viewer


@interruptible()
def film_log(log: Path, target: Path, robot: str | None, options: FilmSizeOptions) -> None:
    """Make a film of a log.

    Raises:
        TsdError: If the log cannot be used, or the film not be made.
    """
    check_film_path(target)
    size = read_size(options)
    found = read_log(log)
    known = load_robot(robot or _robot_of(found))
    # all axes where the log does not tell which are learned
    rate, plotted = rate_of(target), len(found.learned) or None
    clip = make_clip(known, found.fields, found.axes, rate=rate, plotted=plotted)
    what = log.name if found.outline is None else f"{found.outline.motion}, {log.name}"
    _make(known, [clip], target, f"{known.name}: {what}", size)


def _robot_of(log: Log) -> str:
    """Find the robot file of the run on this computer, or a robot of its name."""
    outline = log.outline
    if outline is not None and Path(outline.robot_file).is_file():
        return outline.robot_file
    return log.robot or RobotOptions().robot


def _make(
    robot: Robot, clips: Sequence[Clip], path: Path, title: str, size: tuple[int, int]
) -> None:
    pictures = sum(len(clip.time) for clip in clips)
    with show_progress(f"film {path.name}", pictures) as progress:
        make_film(robot, clips, path, title, size, progress)
    seconds = sum(clip.seconds for clip in clips)
    typer.echo(f"film of {seconds:.1f} s: {path}", err=True)
