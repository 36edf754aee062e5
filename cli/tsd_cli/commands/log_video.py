"""'tsd log video': a film of a log."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsd_cli.commands.log import LogFile
from tsd_cli.option_groups import with_groups
from tsd_cli.options.film import FilmSizeOptions


@with_groups
def film_log(
    log: LogFile,
    film: Annotated[Path, typer.Argument(metavar="FILE", help="The film, .mp4 or .gif.")],
    size: FilmSizeOptions,
    robot: Annotated[
        str | None,
        typer.Option(
            "--robot",
            metavar="ROBOT",
            help="Name of a shipped robot, or path of a robot file (.yaml); by default the "
            "log's robot, for a .csv the one that --robot is elsewhere.",
        ),
    ] = None,
) -> None:
    """Make a film of a log.

    As 'tsd simulate --video' does: the robot, its reference as a ghost, contact forces,
    and error, feedback and feedforward beside it.

      tsd log video run.npz run.mp4
      tsd log video run.npz run.gif --video-size 480x360
    """
    from tsd_cli.actions.film import film_log as make

    make(log, film, robot, size)
