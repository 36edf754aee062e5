"""Bring public humanoids: propose a robot file for each, stand, squat, learn; print a table.

Run: python -m tsd_experiments.beyond.humanoids [--only NAME]... [--mjcf FILE] [--out FOLDER]
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from tsd_casadi.exceptions import TsdError
from tsd_casadi.learning.rules.rule import RuleName
from tsd_clients.console.progress import show_progress
from tsd_clients.console.run_tables import print_goals
from tsd_clients.console.table import Column, console, print_table
from tsd_experiments.beyond.humanoids.described import G1_FEET, HUMANOIDS
from tsd_experiments.beyond.humanoids.learned_squat import learn_squat, propose
from tsd_experiments.harness.section import Goal

RULES: tuple[RuleName, ...] = ("plain", "stable")
# of the robots that are shipped, at 3 cm; as proposed, at the amplitude that is proposed
# there; and of an MJCF alone: by rule, least reduction of RMS and AC error after 1 and 2
SHIPPED, AMPLITUDE = ("g1", "talos"), 0.03
SHIPPED_GOALS = {
    ("plain", "rms"): (50, 1500),
    ("plain", "ac"): (4.5, 40),
    ("stable", "rms"): (200, 20000),
    ("stable", "ac"): (15, 800),
}
PROPOSED_GOALS = {("plain", "rms"): (15, 250), ("stable", "rms"): (45, 5000)}
MJCF_GOALS = {("plain", "rms"): (20, 300)}
CHECK_SECONDS = 2.0


def main() -> None:
    """Learn with every robot that was chosen, on all cores."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--only", action="append", metavar="NAME", help="may be given again")
    parser.add_argument(
        "--mjcf",
        type=Path,
        metavar="FILE",
        help="a G1 as MJCF, such as that of mjlab's asset_zoo, to be proposed for as well",
    )
    parser.add_argument("--out", type=Path, default=Path("results/humanoids"), metavar="FOLDER")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    jobs = _jobs(arguments.out, arguments.mjcf, arguments.only)
    results: dict[str, Any] = {}
    failed: dict[str, str] = {}
    with (
        show_progress("humanoids", len(jobs)) as report,
        ProcessPoolExecutor(mp_context=get_context("spawn")) as pool,
    ):
        running = {pool.submit(learn_squat, *job[0]): name for name, job in jobs.items()}
        for done in as_completed(running):
            try:
                results[running[done]] = done.result()
            except TsdError as error:
                failed[running[done]] = str(error)
            report(len(results) + len(failed), len(jobs))
    results = {name: results[name] for name in jobs if name in results}
    (arguments.out / "humanoids.json").write_text(json.dumps([results, failed], indent=2))
    _print(results)
    for name, reason in failed.items():
        console.print(f"{name} failed: {reason}", markup=False, highlight=False)
    goals = [
        goal for name, result in results.items() for goal in _goals(name, result, jobs[name][1])
    ]
    goals.append(Goal("robots that fail", "<= 0", float(len(failed))))
    print_goals([goal.plain() for goal in goals])


Goals = Mapping[tuple[str, str], tuple[float, float]]
Job = tuple[tuple[str, tuple[RuleName, ...], float | None], Goals]


def _jobs(out: Path, mjcf: Path | None, only: list[str] | None) -> dict[str, Job]:
    """Choose the robots, and write the files of those that are proposed."""
    jobs: dict[str, Job] = {}
    for name in SHIPPED:
        jobs[f"{name}, shipped"] = ((name, RULES, AMPLITUDE), SHIPPED_GOALS)
    wanted = [each for each in HUMANOIDS if only is None or each.name in only]
    for each in wanted:
        file = propose(each.source, each.feet, each.locks, each.name, out)
        jobs[each.name] = ((str(file), RULES, None), PROPOSED_GOALS)
    if mjcf is not None:
        file = propose(mjcf, G1_FEET, (), "g1_mjcf", mjcf.parent)
        jobs["g1, MJCF alone"] = ((str(file), ("plain",), None), MJCF_GOALS)
    return {name: job for name, job in jobs.items() if only is None or name.split(",")[0] in only}


def _goals(name: str, result: dict[str, Any], goals: Goals) -> list[Goal]:
    found = [
        Goal(
            f"{name}: {what.upper()} error, none / {after} iterations, {rule}",
            f">= {goal:g}",
            result[rule][what][0] / result[rule][what][after],
        )
        for (rule, what), pair in goals.items()
        for after, goal in enumerate(pair, start=1)
    ]
    falls = len(result["errors"]) + result["fell"]
    return [
        *found,
        Goal(f"{name}: falls, and errors that the check finds", "<= 0", float(falls)),
        Goal(
            f"{name}: load and check [s of CPU]", f"<= {CHECK_SECONDS:g}", result["check_seconds"]
        ),
    ]


def _print(results: Mapping[str, Any]) -> None:
    def ratios(what: str, rule: str, after: int) -> list[str]:
        return [
            f"{result[rule][what][0] / result[rule][what][after]:.4g}" if rule in result else "-"
            for result in results.values()
        ]

    console.print("\nSquats at 0.25 Hz, P = 50, 10 % wrong model, com.z learned: times smaller")
    print_table(
        "",
        [
            Column("robot", list(results), is_text=True),
            Column("joints", [str(result["joints"]) for result in results.values()], rank=3),
            Column("cm", [f"{100 * result['amplitude']:.2g}" for result in results.values()]),
            *(
                Column(f"{rule}\n{what.upper()} {after}", ratios(what, rule, after), rank=rank)
                for rule in RULES
                for what, rank in (("rms", 0), ("ac", 2))
                for after in (1, 2)
            ),
        ],
    )


if __name__ == "__main__":
    main()
