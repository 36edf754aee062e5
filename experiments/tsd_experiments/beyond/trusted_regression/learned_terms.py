"""Feedforward terms learned over amplitude, frequency and height, to draw designs from."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from itertools import product
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.generalization.gaussian_process import Indices
from tsd_casadi.repetition.learn import learn
from tsd_casadi.robot.robot import load_robot
from tsd_casadi.single_thread import use_single_thread
from tsd_casadi.state import Matrix, Vector
from tsd_experiments.harness.case import Case
from tsd_experiments.harness.learn_case import own_database
from tsd_experiments.harness.run_jobs import cores

NAMES = ("amplitude", "frequency", "height")
FILE = Path(__file__).with_name("learned_terms.npz")
# ends of amplitude [m], frequency [Hz] and height [m]
CUBE = ((0.02, 0.05), (0.3, 0.7), (-0.04, 0.03))
PLANE = ((0.02, 0.08), (0.3, 0.7), (0.0, 0.0))
# along a line all that is asked for is one function of one number: how often a band holds it takes
# several of them
LINES = (
    ((0.02, 0.08), (0.5, 0.5), (0.0, 0.0)),
    ((0.02, 0.05), (0.3, 0.3), (-0.03, -0.03)),
    ((0.04, 0.04), (0.3, 0.7), (0.0, 0.0)),
    ((0.02, 0.02), (0.3, 0.7), (0.02, 0.02)),
    ((0.03, 0.03), (0.5, 0.5), (-0.04, 0.03)),
    ((0.05, 0.05), (0.4, 0.4), (-0.04, 0.03)),
)
ON_A_LINE = 13
ITERATIONS = 4
FIRST_SEED = 1000  # of starting posture and sensor noise, another one for each place


@dataclass(frozen=True)
class LearnedTerms:
    """What was learned at some places.

    Attributes:
        names: Parameters that differ, d of them.
        places: (n, d).
        weights: Along the axis that is moved, (n, L) [m/s^2].
    """

    names: tuple[str, ...]
    places: Matrix
    weights: Matrix

    @property
    def corners(self) -> Indices:
        """Indices of the corners of what was learned."""
        low, high = self.places.min(axis=0), self.places.max(axis=0)
        at_end = np.all((self.places == low) | (self.places == high), axis=1)
        return np.flatnonzero(at_end)


@cache
def load_terms() -> dict[int, list[LearnedTerms]]:
    """Load what was learned by the number of parameters that differ: lines, a plane, a cube."""
    with np.load(FILE) as stored:
        places, weights, ends = stored["places"], stored["weights"], stored["ends"]
    found: dict[int, list[LearnedTerms]] = {1: [], 2: [], 3: []}
    for part in np.split(np.arange(len(places)), ends[:-1]):
        varied = np.flatnonzero(np.ptp(places[part], axis=0) > 0)
        names = tuple(NAMES[column] for column in varied)
        found[len(varied)].append(
            LearnedTerms(names, places[part][:, varied], weights[part].astype(float))
        )
    return found


def learn_terms() -> None:
    """Learn everything again; two cores take three quarters of an hour."""
    parts = [_places(CUBE, 64, 12), _places(PLANE, 32, 13), *map(_line, LINES)]
    places = np.concatenate(parts)
    use_single_thread()
    with ProcessPoolExecutor(cores(), mp_context=get_context("spawn")) as pool:
        weights = list(pool.map(_learn, range(len(places)), map(tuple, places.tolist())))
    ends = np.cumsum([len(part) for part in parts])
    np.savez_compressed(FILE, places=places, weights=np.array(weights, dtype=np.float32), ends=ends)


def _places(ends: Sequence[tuple[float, float]], inside: int, seed: int) -> Matrix:
    """Lay out the corners, and places inside that fill it evenly."""
    from scipy.stats import qmc

    varied = [column for column, (low, high) in enumerate(ends) if low < high]
    corners = np.array(list(product(*(sorted(set(each)) for each in ends))))
    low, high = np.array(ends).T
    shares = np.zeros((inside, len(ends)))
    shares[:, varied] = qmc.Sobol(len(varied), seed=seed).random(inside)
    return np.round(np.concatenate([corners, low + (high - low) * shares]), 6)


def _line(ends: Sequence[tuple[float, float]]) -> Matrix:
    low, high = np.array(ends).T
    return np.asarray(np.round(np.linspace(low, high, ON_A_LINE), 6), dtype=float)


def _learn(number: int, place: tuple[float, float, float]) -> Vector:
    """Learn at one place with all effects of the simulated hardware, in one process of many."""
    robot = load_robot("hermes_lower")
    amplitude, frequency, height = place
    seed = FIRST_SEED + number
    case = Case(amplitude, frequency, height, hardware=("all",), seed=seed)
    with own_database() as database:
        learn(
            case.simulator(robot),
            compile_controller(robot),
            [case.motion],
            database,
            axes=case.axes(robot),
            iterations=ITERATIONS,
            rule="stable",
            laps=2,
            seed=seed,
        )
        return np.asarray(database.entries()[0].iterations[-1].weights[0])
