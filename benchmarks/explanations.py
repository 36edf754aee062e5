"""How long it takes to say why a tick has no solution, and how short the answer is.

Run: python -m benchmarks.explanations [--robot NAME|FILE] [--ticks N] [--check N]

Makes infeasible ticks at random: too weak joints, feet that have to press, slippery
and tiny soles, slow joints, in postures about home. Times the search alone, without the
evaluation of the QP's data. The sets of the first --check ticks are asked of HiGHS: all
rows of a set together, and all but one, each one.
"""

from __future__ import annotations

import argparse
from time import perf_counter

import numpy as np
from scipy.optimize import linprog
from threadpoolctl import threadpool_limits

from tsd_casadi.explanation.conflict import Conflict, find_conflict
from tsd_casadi.explanation.reduced_rows import Indices, ReducedRows, reduce_rows
from tsd_casadi.formulation.inverse_dynamics import InverseDynamics
from tsd_casadi.robot.robot import load_robot
from tsd_casadi.state import Vector
from tsd_casadi.tick.command import Command


class Undecided(Exception):
    """HiGHS does not know."""


KINDS = ("weak joints", "one weak joint", "pressing feet", "slippery soles", "slow joints")


def spoiled_request(problem: InverseDynamics, rng: np.random.Generator) -> Vector:
    """Make a request that has a good chance of being infeasible, for one to three reasons."""
    robot, command = problem.robot, Command(problem.request)
    command["q"][7:] += rng.normal(scale=0.1, size=robot.n)
    command["v"] = rng.normal(scale=0.3, size=robot.nv)
    names = [contact.name for contact in problem.contacts]
    for kind in rng.permutation(KINDS)[: rng.integers(1, 4)]:
        if kind == "weak joints":
            command["limits.torque"] *= rng.uniform(0, 0.3)
        elif kind == "one weak joint":
            command["limits.torque"][rng.integers(robot.n)] *= rng.uniform(0, 0.1)
        elif kind == "pressing feet":
            for name in names:
                command[f"{name}.minimum_force"] = rng.uniform(0, 1.5) * robot.weight
        elif kind == "slippery soles":
            for name in names:
                command[f"{name}.friction"] = rng.uniform(0, 0.02)
                if f"{name}.extents" in command.fields:
                    command[f"{name}.extents"] *= rng.uniform(0, 0.1)
        else:
            command["limits.acceleration"] = rng.uniform(0, 3)
    return command.request


def can_hold(reduced: ReducedRows, places: Indices) -> bool:
    """Ask HiGHS whether rows can hold together, both sides of each."""
    G, h = reduced.G[places], reduced.h[places]
    scale = np.linalg.norm(G, axis=1)
    # it sometimes gives up with one of them
    for method, presolve in (("highs", True), ("highs", False), ("highs-ipm", True)):
        solved = linprog(
            np.zeros(G.shape[1]),
            A_ub=G / scale[:, None],
            b_ub=h / scale,
            bounds=(None, None),
            method=method,
            options={"presolve": presolve},
        )
        if solved.status in (0, 2):
            return bool(solved.status == 0)
    raise Undecided


def is_irreducible(reduced: ReducedRows, conflict: Conflict) -> bool:
    """Check that a set cannot hold, and that it can without any one of its rows."""
    rows = reduced.rows[conflict.places]
    whole = np.flatnonzero(np.isin(reduced.rows, rows))
    return not can_hold(reduced, whole) and all(
        can_hold(reduced, whole[reduced.rows[whole] != row]) for row in rows
    )


def measure(robot: str, ticks: int, checked: int) -> None:
    """Print sizes, times and how many sets were irreducible."""
    problem, rng = InverseDynamics(load_robot(robot)), np.random.default_rng(0)
    sizes, others, times, irreducible, undecided, asked = [], [], [], 0, 0, 0
    while len(sizes) < ticks:
        asked += 1
        program = problem.evaluate(spoiled_request(problem, rng))
        before = perf_counter()
        reduced = reduce_rows(program, problem.nv, problem.n_equalities)
        conflict = find_conflict(reduced)
        elapsed = perf_counter() - before
        if conflict is None:
            continue
        times.append(1e3 * elapsed)
        if len(sizes) < checked:
            try:
                irreducible += is_irreducible(reduced, conflict)
            except Undecided:
                undecided += 1
        sizes.append(len(conflict.places))
        others.append(int(np.sum(~reduced.is_bound[conflict.places])))
    count = min(checked, ticks)
    print(f"{robot}: {ticks} infeasible ticks out of {asked}, free directions {reduced.Z.shape[1]}")
    print(f"irreducible by HiGHS: {irreducible} of {count} checked, {undecided} undecided")
    for name, values in (
        ("rows", sizes),
        ("rows besides limits of accelerations", others),
        ("time in ms", times),
    ):
        p10, p50, p90, p99 = np.percentile(values, [10, 50, 90, 99])
        print(f"{name}: p10 {p10:.3g}, median {p50:.3g}, p90 {p90:.3g}, p99 {p99:.3g}")


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="hermes_lower")
    parser.add_argument("--ticks", type=int, default=10_000)
    parser.add_argument("--check", type=int, default=200)
    options = parser.parse_args()
    with threadpool_limits(1):
        measure(options.robot, options.ticks, options.check)


if __name__ == "__main__":
    main()
