"""Where results go."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer


@dataclass(frozen=True, kw_only=True)
class JsonOptions:
    """Output."""

    json_file: Annotated[
        str | None,
        typer.Option(
            "--json",
            metavar="FILE",
            help="Write the result as JSON to a file, or - for stdout.",
        ),
    ] = None


@dataclass(frozen=True, kw_only=True)
class LogOptions(JsonOptions):
    """Output."""

    log: Annotated[
        Path | None,
        typer.Option(
            "--log",
            metavar="FILE",
            help="Write every tick to this file, .csv, .npz or (for ROS) .mcap: docs/logs.md.",
        ),
    ] = None
