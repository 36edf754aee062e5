"""'tsd log': what a run wrote with --log."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsd_cli.option_groups import with_groups
from tsd_cli.options.output import JsonOptions

LogFile = Annotated[
    Path,
    typer.Argument(metavar="LOG", help="What --log wrote: .npz, .csv or .mcap."),
]
Target = Annotated[
    Path,
    typer.Argument(metavar="TARGET", help="File that is made, .npz, .csv or .mcap."),
]


@with_groups
def show_log(log: LogFile, output: JsonOptions) -> None:
    """Say what a log is of and how it went.

    Robot, motion, laps, and the error along each axis, computed from its ticks; what was
    missed, which limits were reached.

      tsd log show run.mcap
      tsd log show run.npz --json -
    """
    from tsd_cli.actions.log import show

    show(log, output)


@with_groups
def cut_log(
    log: LogFile,
    target: Target,
    first: Annotated[
        float | None,
        typer.Option("--from", metavar="SECONDS", help="First moment; by default the beginning."),
    ] = None,
    last: Annotated[
        float | None,
        typer.Option("--to", metavar="SECONDS", help="Last moment; by default the end."),
    ] = None,
    laps: Annotated[
        str | None,
        typer.Option("--laps", metavar="FIRST:LAST", help="Whole laps instead, from 0 on."),
    ] = None,
) -> None:
    """Write a part of a log into another file: some of its time, or some of its laps.

    Both ends are in the part. A .mcap is copied message by message.

      tsd log cut run.mcap part.mcap --from 2 --to 3.5
      tsd log cut run.mcap laps.npz --laps 1:2
    """
    from tsd_cli.actions.log import cut

    cut(log, target, first, last, laps)


@with_groups
def convert_log(log: LogFile, target: Target) -> None:
    """Write a log in another format, which the ending of the target names.

    An .npz becomes a .mcap with what it has; a .csv does not tell the robot and cannot.

      tsd log convert run.mcap run.npz
      tsd log convert run.npz run.mcap
    """
    from tsd_cli.actions.log import convert

    convert(log, target)


@with_groups
def plot_log(
    log: LogFile,
    picture: Annotated[
        Path | None,
        typer.Argument(
            metavar="PICTURE", help="A .png, .pdf or .svg; by default beside the log, as .png."
        ),
    ] = None,
) -> None:
    """Draw error, feedback and feedforward of every axis, and torques against their limits.

    tsd log plot run.mcap
    tsd log plot run.npz run.pdf
    """
    from tsd_cli.actions.log import plot

    plot(log, picture)


@with_groups
def recover_log(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A .mcap that is not whole.")],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", metavar="FILE", help="Write there, and leave the log as it is, instead."
        ),
    ] = None,
) -> None:
    """Make the log of a run whole whose processes were killed.

    Keeps everything but the last chunk, about ten ticks, and says what it kept. The laps
    that are measured are then the last two whole ones.

      tsd log recover run.mcap
      tsd log recover run.mcap --out readable.mcap
    """
    from tsd_cli.actions.log import recover

    recover(log, out)
