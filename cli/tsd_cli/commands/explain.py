"""'tsd explain': one tick of a log."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsd_cli.option_groups import with_groups
from tsd_cli.options.output import JsonOptions


@with_groups
def explain(
    log: Annotated[
        Path, typer.Argument(metavar="LOG", help="What --log wrote: .npz, .csv or .mcap.")
    ],
    output: JsonOptions,
    tick: Annotated[
        int | None,
        typer.Option(
            "--tick",
            metavar="N",
            min=0,
            help="Which tick, from 0 on; by default the first that failed, else the last.",
        ),
    ] = None,
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
    """Say why a tick had no solution, or what its limits cost the tasks.

    Of a tick without a solution: limits that cannot hold together, none of them too many,
    and by how much. Of another one: how much acceleration each active limit takes from
    each task. docs/explain.md has a case of each.

      tsd simulate squat --controller local --log run.npz
      tsd explain run.npz
      tsd explain run.npz --tick 2400 --json -
    """
    from tsd_cli.actions.explain import explain_tick

    explain_tick(log, tick, robot, output)
