"""'tsd demo' and 'tsd reproduce'."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsd_cli.option_groups import with_groups
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.robot import RobotOptions


@with_groups
def demo(
    robot: RobotOptions,
    out: Annotated[
        Path,
        typer.Option("--out", metavar="FOLDER", help="Folder for summary, logs and figures."),
    ] = Path("results/demo"),
) -> None:
    """Show everything: services, learning, lower gains, generalisation (3 to 5 minutes).

    tsd demo
    """
    from tsd_cli.actions.experiments import show_demo

    show_demo(robot, out)


@with_groups
def reproduce(
    robot: RobotOptions,
    output: JsonOptions,
    figure: Annotated[
        int | None,
        typer.Option(
            "--figure", metavar="N", help="Only this figure of the paper: 2, 3, 4, 5 or 6."
        ),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="A short form of everything, in under five minutes.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="FOLDER",
            help="Folder for data, figures, report.html and summary.json. Default: results/paper, "
            "with --quick results/paper-quick.",
        ),
    ] = None,
    page: Annotated[
        Path | None,
        typer.Option(
            "--page", metavar="FILE", help="Write the report as Markdown to this file (.md) too."
        ),
    ] = None,
) -> None:
    """Run the paper's experiments and those beyond it; under 45 minutes on two cores.

    What is finished is kept in the folder and not run again, so an interrupted
    run goes on where it stopped. It is kept until robot, arguments or version
    change: after a change of the code choose another --out.

      tsd reproduce --quick
      tsd reproduce --figure 4 --quick --out figure-4
    """
    from tsd_cli.actions.experiments import reproduce_paper

    reproduce_paper(robot, output, figure, quick, out, page)
