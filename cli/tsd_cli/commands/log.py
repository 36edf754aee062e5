"""'tsd log': what a run wrote with --log."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsd_cli.option_groups import with_groups
from tsd_cli.options.output import JsonOptions

LogFile = Annotated[Path, typer.Argument(metavar="LOG", help="What 'tsd simulate --log' wrote.")]


@with_groups
def show_log(log: LogFile, output: JsonOptions) -> None:
    """Say what a log is of and how it went.

    Robot, motion, laps, and the error along each axis, computed from its ticks; what was
    missed, which limits were reached.

      tsd log show run.npz
      tsd log show run.npz --json -
    """
    from tsd_cli.actions.log import show

    show(log, output)
