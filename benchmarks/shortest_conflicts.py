"""How few limits that cannot hold together there are at all: bounds that linear programs prove.

Run: python -m benchmarks.shortest_conflicts [--robot NAME|FILE] [--ticks N] [--seconds S]

On the first ticks of ``benchmarks.explanations``. Where the other rows can hold once some
rows are given up, every set that cannot hold has one of these (or it could). So no set
is shorter than the fewest rows of which each such collection has one; and where those
cannot hold together, they are the shortest set (implicit hitting sets: Ignatiev, Previti,
Liffiton and Marques-Silva, Smallest MUS Extraction with Minimal Hitting Set
Dualisation, CP 2015). Elastic linear programs with random weights find collections.
"""

from __future__ import annotations

import argparse
from time import perf_counter

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, linprog, milp
from threadpoolctl import threadpool_limits

from benchmarks.explanations import Undecided, spoiled_request
from tsd_casadi.explanation.conflict import UNIT, find_conflict
from tsd_casadi.explanation.least_distance import find_nearest_point
from tsd_casadi.explanation.reduced_rows import Indices, ReducedRows, reduce_rows
from tsd_casadi.formulation.inverse_dynamics import InverseDynamics
from tsd_casadi.robot.robot import load_robot

# Rows of length 1 [m/s^2, rad/s^2, N]: what gives way by more is given up. HiGHS keeps rows
# to 1e-7.
GIVEN_UP = 1e-6
# collections that are looked for before the fewest rows are counted again
TURNS = 12
# of the solver that counts them, in rows: 0.02 of a row is no row
ROUNDING = 0.02
# [s] for one count
PATIENCE = 5.0


class Search:
    """For the shortest set of one tick.

    Attributes:
        least: No set has fewer rows.
        shortest: Rows of the shortest set that was found.
    """

    def __init__(self, reduced: ReducedRows, shortest: int) -> None:
        """Begin with a set that was found otherwise."""
        norms = np.linalg.norm(reduced.G, axis=1)
        self._G, self._h = reduced.G / norms[:, None], reduced.h / norms
        self._rng = np.random.default_rng(0)
        self._collections: list[Indices] = []
        self.least, self.shortest = 1, shortest

    def run(self, seconds: float) -> None:
        """Close the gap, for so long at most."""
        end = perf_counter() + seconds
        while self.least < self.shortest and perf_counter() < end:
            rows = self._fewest()
            for _ in range(TURNS):
                if not self._extend(rows):
                    self.shortest = min(self.shortest, len(rows))
                    break

    def _fewest(self) -> list[int]:
        """Find few rows, one of each collection, and how few they can be."""
        count = len(self._h)
        if not self._collections:
            return []
        meets = np.zeros((len(self._collections), count))
        for row, collection in zip(meets, self._collections, strict=True):
            row[collection] = 1.0
        solved = milp(
            np.ones(count),
            constraints=LinearConstraint(meets, 1.0),
            integrality=np.ones(count),
            bounds=Bounds(0.0, 1.0),
            options={"time_limit": PATIENCE},
        )
        self.least = max(self.least, int(np.ceil(solved.mip_dual_bound - ROUNDING)))
        return [] if solved.x is None else np.flatnonzero(solved.x > 0.5).tolist()

    def _extend(self, rows: list[int]) -> bool:
        """Add rows of what is given up for these until they cannot hold; False if that is so."""
        kept = list(rows)
        while (given_up := self._give_up(kept)) is not None:
            self._collections.append(given_up)
            kept.append(int(self._rng.choice(given_up)))
        point = find_nearest_point(self._G[kept], self._h[kept] / UNIT)
        if point.z is None:
            self.shortest = min(self.shortest, int(np.sum(point.multipliers > 0)))
        return len(kept) > len(rows)

    def _give_up(self, kept: list[int]) -> Indices | None:
        """Which others have to be given up for these to hold; None if they cannot."""
        m, n = self._G.shape
        weights = self._rng.exponential(size=m) + 0.05
        most = np.full(m, np.inf)
        most[kept] = 0.0
        # HiGHS sometimes gives up with one of them
        for method, presolve in (("highs", True), ("highs", False), ("highs-ipm", True)):
            solved = linprog(
                np.concatenate((np.zeros(n), weights)),
                A_ub=np.hstack((self._G, -np.eye(m))),
                b_ub=self._h,
                bounds=[(None, None)] * n + [(0.0, each) for each in most],
                method=method,
                options={"presolve": presolve},
            )
            if solved.status == 2:
                return None
            if solved.status == 0:
                given_up = np.flatnonzero(solved.x[n:] > GIVEN_UP)
                return given_up if len(given_up) else None
        raise Undecided


def measure(name: str, ticks: int, seconds: float) -> None:
    """Print what was found, what is proved and the shortest set that was met."""
    problem, rng = InverseDynamics(load_robot(name)), np.random.default_rng(0)
    rows: list[tuple[int, int, int]] = []
    undecided = 0
    while len(rows) + undecided < ticks:
        program = problem.evaluate(spoiled_request(problem, rng)[0])
        reduced = reduce_rows(program, problem.nv, problem.n_equalities)
        conflict = find_conflict(reduced)
        if conflict is None:
            continue
        search = Search(reduced, len(conflict.places))
        try:
            search.run(seconds)
        except Undecided:
            undecided += 1
            continue
        rows.append((len(conflict.places), search.least, search.shortest))
        print(
            f"found {rows[-1][0]}, at least {rows[-1][1]}, shortest met {rows[-1][2]}", flush=True
        )
    found, least, shortest = np.array(rows).T
    print(
        f"{name}: {len(rows)} ticks, {undecided} undecided. Median rows: found "
        f"{np.median(found):g}, at least {np.median(least):g}, shortest met "
        f"{np.median(shortest):g}. At least 5 in {np.sum(least >= 5)}."
    )


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="hermes_lower")
    parser.add_argument("--ticks", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=20.0, help="for each tick")
    options = parser.parse_args()
    with threadpool_limits(1):
        measure(options.robot, options.ticks, options.seconds)


if __name__ == "__main__":
    main()
