"""Examining a robot file."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import typer

from tsd_casadi.examination.examine import Examination, examine
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_cli.actions.prepare import compile_with_activity
from tsd_cli.interrupt import interruptible
from tsd_cli.options.output import JsonOptions
from tsd_cli.output import STDOUT, check_outputs, put_out
from tsd_clients.console.examination_tables import print_examination
from tsd_clients.console.progress import show_activity, show_progress
from tsd_clients.film.gl_library import HINT
from tsd_clients.film.rendering import render_postures, side_by_side

CANNOT_WORK = 1


@interruptible()
def check_robot_file(robot_file: str, pictures: Path | None, output: JsonOptions) -> None:
    """Examine a robot; exit with 1 if it cannot work.

    Args:
        pictures: Folder for them, None for none.

    Raises:
        TsdError: If the file cannot be used at all.
    """
    check_outputs(output)
    robot = load_robot(robot_file)
    controller = compile_with_activity(robot)
    with show_progress(f"examining {robot.name}", 1) as report:
        examination = examine(robot, controller, report)
    put_out(
        {"robot": robot.name, **examination.plain()},
        output,
        lambda: print_examination(robot.name, examination.plain()),
    )
    if pictures is not None:
        _draw(robot, examination, pictures)
    if examination.works and output.json_file != STDOUT:
        _tell_next(robot_file, examination)
    if not examination.works:
        raise typer.Exit(CANNOT_WORK)


def _tell_next(robot_file: str, examination: Examination) -> None:
    """Write the commands that come next, to be copied."""
    motions = [demands.motion.name for demands in examination.demands]
    if not motions:
        return
    motion = "squat" if "squat" in motions else motions[0]
    rest = f"{motion} --robot {shlex.quote(robot_file)} --controller local --model-error 0.1"
    # not broken into lines
    typer.echo(f"next: tsd simulate {rest}")
    typer.echo("then, with 'tsd learner' in a second terminal:")
    typer.echo(f"      tsd learn {rest} --rule stable --iterations 2")


def _draw(robot: Robot, examination: Examination, folder: Path) -> None:
    from matplotlib.image import imsave

    largest = {each.motion.name: each for each in examination.demands if each.extremes}
    postures = [robot.home.q]
    for demands in largest.values():
        postures += [posture.q for posture in demands.extremes]
    with show_activity("drawing"):
        frames = render_postures(robot, np.array(postures))
    if frames is None:
        typer.echo(HINT, err=True)
        return
    folder.mkdir(parents=True, exist_ok=True)
    imsave(folder / "home.png", frames[0])
    for index, name in enumerate(largest):
        imsave(folder / f"{name}.png", side_by_side(frames[1 + 2 * index : 3 + 2 * index]))
    # as of a film: stdout may be JSON
    typer.echo(f"pictures of home and of each motion's extremes: {folder}", err=True)
