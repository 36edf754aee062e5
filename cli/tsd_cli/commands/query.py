"""'tsd query' and 'tsd database': what the learner knows."""

from __future__ import annotations

from typing import Annotated

import typer

from tsd_cli.option_groups import with_groups
from tsd_cli.options.listing import ListingOptions
from tsd_cli.options.motion import CorrectionFile, MotionOptions
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.robot import RobotOptions
from tsd_cli.options.services import ConnectOptions


@with_groups
def query(
    motion: MotionOptions,
    robot: RobotOptions,
    services: ConnectOptions,
    output: JsonOptions,
    kind: Annotated[
        str | None,
        typer.Option("--kind", help="learned or generalised; default: learned where it exists."),
    ] = None,
    extrapolate: Annotated[
        bool, typer.Option("--extrapolate", help="Answer outside the learned range too.")
    ] = False,
    com_correction: CorrectionFile = None,
) -> None:
    """Ask the learner what to feed forward.

    The exact entry where there is one, else generalised from the others:

      tsd query squat --amplitude 0.05
      tsd query squat --amplitude 0.05 --kind generalised --json feedforward.json
    """
    from tsd_cli.actions.ask import ask_feedforward

    ask_feedforward(motion, robot, kind, extrapolate, com_correction, services, output)


@with_groups
def list_entries(listing: ListingOptions, services: ConnectOptions, output: JsonOptions) -> None:
    """List what was learned, as much of it as was learned last.

    tsd database list
    tsd database list --motion squat --limit 500
    tsd database list --json -
    """
    from tsd_cli.actions.entries import list_entries

    list_entries(listing, services, output)


@with_groups
def forget_entry(
    services: ConnectOptions,
    entry: Annotated[
        int,
        typer.Argument(metavar="ENTRY", help="Number of the entry, from 'tsd database list'."),
    ],
) -> None:
    """Remove one entry with all its iterations.

    tsd database forget 3
    """
    from tsd_cli.actions.entries import forget

    forget(entry, services)
