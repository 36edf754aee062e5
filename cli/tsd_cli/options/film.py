"""How a run is looked at."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer


@dataclass(frozen=True, kw_only=True)
class FilmSizeOptions:
    """Film."""

    video_size: Annotated[
        str,
        typer.Option(
            "--video-size", metavar="WIDTHxHEIGHT", help="Of the film in pixels, even numbers."
        ),
    ] = "640x480"


@dataclass(frozen=True, kw_only=True)
class FilmOptions(FilmSizeOptions):
    """Film."""

    video: Annotated[
        Path | None,
        typer.Option(
            "--video",
            metavar="FILE",
            help="Make a film, .mp4 or .gif: the robot, its reference as a ghost, contact forces, "
            "and error, feedback and feedforward beside it.",
        ),
    ] = None
    viewer: Annotated[
        bool,
        typer.Option(
            "--viewer", help="Show the robot in MuJoCo's viewer while it moves; needs a desktop."
        ),
    ] = False
