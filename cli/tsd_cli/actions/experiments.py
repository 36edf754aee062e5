"""The demonstration and the experiments."""

from __future__ import annotations

from pathlib import Path

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.robot.robot import load_robot
from tsd_cli.interrupt import interruptible
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.robot import RobotOptions
from tsd_cli.output import check_outputs, put_out
from tsd_clients.console.run_tables import print_goals
from tsd_clients.console.table import console
from tsd_experiments.demo.run_demo import run_demo
from tsd_experiments.reproduce import reproduce


@interruptible()
def show_demo(robot: RobotOptions, out: Path) -> None:
    """Run the demonstration.

    Raises:
        TsdError: If a service does not start or a run fails.
    """
    run_demo(load_robot(robot.robot), out)


@interruptible("the same command goes on with what is left")
def reproduce_paper(
    robot: RobotOptions,
    output: JsonOptions,
    figure: int | None,
    quick: bool,
    out: Path | None,
    page: Path | None,
) -> None:
    """Run the experiments and show which goals were met.

    Args:
        figure: Only this figure of the paper.
        out: Folder of the results; None for the usual one.
        page: Markdown file to write as well.

    Raises:
        TsdError: If they cannot be done as asked.
    """
    if page is not None and page.suffix != ".md":
        raise InvalidValue("--page", f"'{page}'", "a file that ends in .md")
    check_outputs(output, page)
    folder = out or Path("results/paper-quick" if quick else "results/paper")
    loaded = load_robot(robot.robot)
    summary = reproduce(loaded, folder, figure=figure, quick=quick, page=page)

    def show() -> None:
        print_goals(summary["rows"])
        seconds = sum(summary["seconds"].values())
        console.print(f"{seconds:.0f} s in all; {folder / 'report.html'}")

    put_out(summary, output, show)
