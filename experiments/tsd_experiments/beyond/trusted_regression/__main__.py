"""Print what the regression's predictions are worth, from few entries and from wrong ones.

Run: python -m tsd_experiments.beyond.trusted_regression [--quick] [--first-seed N] [--learn]
"""

from __future__ import annotations

import argparse

from tsd_clients.console.run_tables import print_goals
from tsd_clients.console.table import Column, print_table
from tsd_experiments.beyond.trusted_regression.fixed_methods import FIXED
from tsd_experiments.beyond.trusted_regression.learned_terms import learn_terms
from tsd_experiments.beyond.trusted_regression.rows import (
    compare_with_fixed,
    contradict,
    cover,
    predict_from_few,
)

DESIGNS, QUICK_DESIGNS = 20, 2
# a share of curves takes more of them
TIMES_FOR_COVERAGE = 3


def main() -> None:
    """Draw designs, print medians and goals."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--quick", action="store_true", help="two designs of each kind")
    parser.add_argument("--first-seed", type=int, default=0, metavar="N", help="of the designs")
    parser.add_argument(
        "--learn", action="store_true", help="learn the terms again first, half an hour"
    )
    arguments = parser.parse_args()
    if arguments.learn:
        learn_terms()
    first = arguments.first_seed
    count = QUICK_DESIGNS if arguments.quick else DESIGNS
    seeds, more = range(first, first + count), range(first, first + TIMES_FOR_COVERAGE * count)
    goals, rows = compare_with_fixed(seeds)
    head = ["", *FIXED, "regression"]
    print_table(
        "median error of the curves, amplitude x frequency x height [mm/s²]",
        [
            Column(heading, list(cells), is_text=place == 0)
            for place, (heading, cells) in enumerate(
                zip(head, zip(*rows, strict=True), strict=True)
            )
        ],
    )
    print_goals(
        [
            goal.plain()
            for goal in (*goals, *predict_from_few(seeds), *contradict(seeds), *cover(more))
        ]
    )


if __name__ == "__main__":
    main()
