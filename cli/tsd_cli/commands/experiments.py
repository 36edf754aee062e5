"""'tsd demo' and 'tsd reproduce'."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.robot.robot import load_robot
from tsd_cli.commands.options import (
    ROBOT,
    JsonOption,
    RobotOption,
)
from tsd_cli.commands.output import check_writable, put_out
from tsd_clients.console.tables import console, print_goals


def demo(
    robot: RobotOption = ROBOT,
    out: Annotated[
        Path, typer.Option("--out", help="Folder for summary, logs and figures.")
    ] = Path("results/demo"),
) -> None:
    """Show everything: services, learning, lower gains, generalisation (about 3 minutes)."""
    from tsd_experiments.demo import run_demo

    run_demo(load_robot(robot), out)


def reproduce(
    figure: Annotated[
        int | None,
        typer.Option("--figure", help="Only this figure of the paper: 2, 3, 4, 5 or 6."),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="A short form of everything, in under five minutes.")
    ] = False,
    robot: RobotOption = ROBOT,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            help="Folder for data, figures, report.html and summary.json. Default: results/paper, "
            "with --quick results/paper-quick.",
        ),
    ] = None,
    page: Annotated[
        Path | None,
        typer.Option("--page", help="Write the report as Markdown to this file (.md) too."),
    ] = None,
    json_file: JsonOption = None,
) -> None:
    """Run the paper's experiments and those beyond it; under 45 minutes on two cores.

    What is finished is kept in the folder and not run again, so an interrupted
    run goes on where it stopped. It is kept until robot, arguments or version
    change: after a change of the code choose another --out.
    """
    from tsd_experiments.run import reproduce as run_experiments

    if page is not None and page.suffix != ".md":
        raise InvalidValue("--page", f"'{page}'", "a file that ends in .md")
    check_writable(json_file, page)
    if out is None:
        out = Path("results/paper-quick" if quick else "results/paper")
    try:
        summary = run_experiments(load_robot(robot), out, figure=figure, quick=quick, page=page)
    except KeyboardInterrupt:
        typer.echo("interrupted; the same command goes on with what is left", err=True)
        raise

    def show() -> None:
        print_goals(summary["rows"])
        console.print(f"{sum(summary['seconds'].values()):.0f} s in all; {out / 'report.html'}")

    put_out(summary, json_file, show)
