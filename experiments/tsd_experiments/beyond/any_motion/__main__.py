"""Learn any motion and print what came of it.

Run: python -m tsd_experiments.beyond.any_motion [--quick] [--robot NAME|FILE] [--out FOLDER]
     [--figure FILE]
"""

from __future__ import annotations

import argparse
from pathlib import Path

from matplotlib import pyplot as plt
from rich.markup import escape

from tsd_casadi.robot.robot import load_robot
from tsd_clients.console.run_tables import print_goals
from tsd_clients.console.table import Column, console, print_table
from tsd_experiments.beyond.any_motion.experiment import AnyMotion
from tsd_experiments.harness.store import Store
from tsd_experiments.reproduce import check_cases, run_all


def main() -> None:
    """Run what is not done yet, print tables and goals."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--quick", action="store_true", help="one seed and one rule")
    parser.add_argument("--robot", default="hermes_lower", metavar="NAME|FILE")
    parser.add_argument("--out", type=Path, default=Path("results/any_motion"), metavar="FOLDER")
    parser.add_argument("--figure", type=Path, metavar="FILE", help="write the picture there")
    arguments = parser.parse_args()
    robot, experiment = load_robot(arguments.robot), AnyMotion(arguments.quick)
    check_cases([experiment], robot)
    section = experiment.report(run_all([experiment], Store(arguments.out / "data", robot)))
    for table in section.tables:
        columns = [list(cells) for cells in zip(*table.rows, strict=True)]
        console.print(escape(f"\n{table.caption}"))
        print_table(
            "",
            [
                # headings in two lines, so that all columns fit 80 characters
                Column(head.replace(" after", "\nafter"), cells, rank=int(place == 2))
                for place, (head, cells) in enumerate(zip(table.head, columns, strict=True))
            ],
        )
    print_goals([goal.plain() for goal in section.goals])
    for sentence in section.found:
        console.print(sentence)
    if arguments.figure is not None:
        for figure in section.figures:
            drawn = figure.draw()
            drawn.savefig(arguments.figure, dpi=110)
            plt.close(drawn)


if __name__ == "__main__":
    main()
