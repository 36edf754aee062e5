"""How long it takes to say why a tick has no solution, and how short the answer is.

Run: python -m benchmarks.explanations [--robot NAME|FILE] [--ticks N] [--check N]

Makes infeasible ticks at random: too weak joints, feet that have to press, slippery
and tiny soles, slow joints, in postures about home. Times what the search adds to a tick,
and that of `tsd explain` without the evaluation of the QP's data. The sets of the first --check
ticks are asked of HiGHS: all rows of a set together, and all but one, each one.
"""

from __future__ import annotations

import argparse
from time import perf_counter

import numpy as np
from scipy.optimize import linprog
from threadpoolctl import threadpool_limits

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.explanation.conflict import Conflict, find_conflict
from tsd_casadi.explanation.reduced_rows import Indices, ReducedRows, reduce_rows
from tsd_casadi.formulation.inverse_dynamics import InverseDynamics
from tsd_casadi.robot.robot import load_robot
from tsd_casadi.state import Vector
from tsd_casadi.tick.command import Command
from tsd_casadi.tick.format import Status
from tsd_casadi.tick.tick import Tick


class Undecided(Exception):
    """HiGHS does not know."""


KINDS = ("weak joints", "one weak joint", "pressing feet", "slippery soles", "slow joints")


def spoiled_request(
    problem: InverseDynamics, rng: np.random.Generator
) -> tuple[Vector, frozenset[str]]:
    """Make a request that has a good chance of being infeasible, for one to three reasons."""
    robot, command = problem.robot, Command(problem.request)
    command["q"][7:] += rng.normal(scale=0.1, size=robot.n)
    command["v"] = rng.normal(scale=0.3, size=robot.nv)
    # they yield before anything is infeasible
    command["limits.position_active"] = command["limits.velocity_active"] = 0.0
    names = [contact.name for contact in problem.contacts]
    reasons = rng.permutation(KINDS)[: rng.integers(1, 4)]
    for kind in reasons:
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
    return command.request, frozenset(reasons.tolist())


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


class Tally:
    """Sets found by one of two ways."""

    def __init__(self) -> None:
        """Begin with none."""
        self.rows: list[int] = []
        self.others: list[int] = []
        self.times: list[float] = []
        self.irreducible = self.undecided = 0

    def add(self, conflict: Conflict, reduced: ReducedRows, time: float, check: bool) -> None:
        """Count one.

        Args:
            time: Of the search [us].
        """
        self.rows.append(len(conflict.places))
        self.others.append(int(np.sum(~reduced.is_bound[conflict.places])))
        self.times.append(time)
        if check:
            try:
                self.irreducible += is_irreducible(reduced, conflict)
            except Undecided:
                self.undecided += 1

    def show(self, name: str, checked: int) -> None:
        """Print sizes, times and how many sets were irreducible."""
        print(f"{name}, irreducible by HiGHS: {self.irreducible} of {checked} checked")
        if self.undecided:
            print(f"  {self.undecided} undecided")
        for what, values in (
            ("rows", self.rows),
            ("rows besides limits of accelerations", self.others),
            ("time in us", self.times),
        ):
            p10, p50, p90, p99 = np.percentile(values, [10, 50, 90, 99])
            print(f"  {what}: p10 {p10:.3g}, median {p50:.3g}, p90 {p90:.3g}, p99 {p99:.3g}")


def conflict_of(tick: Tick, reduced: ReducedRows) -> Conflict:
    """Find the reply's rows among the reduced ones."""
    rows = np.array([tick.format.row_names.index(name) for name in tick.conflict], dtype=int)
    amounts = np.array(list(tick.conflict.values()))
    place = {
        (row, side): index
        for index, (row, side) in enumerate(zip(reduced.rows, reduced.sides, strict=True))
    }
    places = [place[row, side] for row, side in zip(rows, np.sign(amounts), strict=True)]
    return Conflict(np.array(places, dtype=int), np.abs(amounts))


def measure(name: str, ticks: int, checked: int) -> None:
    """Ask the controller and the definition about the same ticks."""
    robot = load_robot(name)
    controller, problem = compile_controller(robot), InverseDynamics(robot)
    rng, asked, same = np.random.default_rng(0), 0, 0
    replied, defined = Tally(), Tally()
    alone = {kind: [0, 0] for kind in KINDS}
    explained, time = problem.request.slice("explain"), controller.format.reply.slice("solve_time")
    while len(defined.rows) < ticks:
        asked += 1
        request, reasons = spoiled_request(problem, rng)
        program = problem.evaluate(request)
        before = perf_counter()
        reduced = reduce_rows(program, problem.nv, problem.n_equalities)
        conflict = find_conflict(reduced)
        elapsed = 1e6 * (perf_counter() - before)
        if len(reasons) == 1:
            (reason,) = reasons
            alone[reason][conflict is not None] += 1
        silent = controller.run(request)[time][0]
        request[explained] = 1.0
        tick = Tick(controller.format, controller.run(request))
        if conflict is None or tick.status != Status.INFEASIBLE:
            # near the border 1e-6 decides
            continue
        check = len(defined.rows) < checked
        defined.add(conflict, reduced, elapsed, check)
        told = conflict_of(tick, reduced)
        replied.add(told, reduced, tick.reply[time][0] - silent, check)
        same += set(told.places) == set(conflict.places)
    print(f"{name}: {ticks} infeasible ticks out of {asked}, free directions {reduced.Z.shape[1]}")
    replied.show("in the reply", min(checked, ticks))
    defined.show("tsd explain", min(checked, ticks))
    print(f"the same set: {same}")
    for kind, (feasible, infeasible) in alone.items():
        print(f"{kind} alone: {infeasible} of {feasible + infeasible} ticks infeasible")


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
