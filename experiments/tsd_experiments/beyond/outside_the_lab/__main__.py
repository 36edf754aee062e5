"""Learn on a robot that shakes or changes; print what is reached, with its goals.

Run: python -m tsd_experiments.beyond.outside_the_lab [--robot NAME] [--row NAME]... [--seeds N]
"""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

from tsd_casadi.learning.rules.by_name import RULES, find_rule
from tsd_clients.console.progress import show_progress
from tsd_clients.console.run_tables import print_goals
from tsd_experiments.beyond.outside_the_lab.budget import print_budget
from tsd_experiments.beyond.outside_the_lab.experiment import ROWS, Results, goals_of, jobs_of
from tsd_experiments.harness.run_jobs import cores


def main() -> None:
    """Learn with every seed, on all cores."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--seeds", type=int, default=10, metavar="N", help="how many")
    parser.add_argument("--first-seed", type=int, default=0, metavar="N", help="of them")
    parser.add_argument("--robot", default="hermes_lower", metavar="NAME|FILE")
    parser.add_argument("--row", action="append", choices=ROWS, help="may be given again")
    parser.add_argument("--rule", default="adaptive", choices=list(RULES))
    parser.add_argument("--iterations", type=int, default=40, help="of the row 'quiet'")
    parser.add_argument("--processes", type=int, default=cores())
    parser.add_argument("--out", type=Path, default=Path("results/outside_the_lab"))
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    rule = find_rule(arguments.rule).name
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.seeds)
    jobs = jobs_of(arguments.row or ROWS, arguments.robot, rule, seeds, arguments.iterations)
    results: Results = {}
    with (
        show_progress("outside the lab", len(jobs)) as report,
        ProcessPoolExecutor(arguments.processes, get_context("spawn")) as pool,
    ):
        running = {pool.submit(job.function, *job.arguments): job for job in jobs}
        for done in as_completed(running):
            job = running[done]
            results.setdefault(job.row, []).append({"seed": job.seed, **done.result()})
            report(sum(map(len, results.values())), len(jobs))
            text = json.dumps({"robot": arguments.robot, "rule": rule, "rows": results}, indent=2)
            (arguments.out / f"{rule}.json").write_text(text)
    print_budget(results.get("noise", []))
    print_goals([goal.plain() for goal in goals_of(results)])


if __name__ == "__main__":
    main()
