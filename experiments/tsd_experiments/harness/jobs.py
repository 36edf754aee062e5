"""Jobs: pieces of work that are done once, on all cores, and kept."""

from __future__ import annotations

import hashlib
import json
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from functools import lru_cache
from multiprocessing import active_children, get_context
from pathlib import Path
from time import time
from typing import Any
from zipfile import BadZipFile

import mujoco
import numpy as np

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.controller.controller import Controller
from tsd_casadi.exceptions import SimulationError, TsdError
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_casadi.state import Vector
from tsd_casadi.version import __version__
from tsd_experiments.harness.case import Outcome
from tsd_experiments.harness.duration import Span
from tsd_experiments.harness.services import start_services


@dataclass(frozen=True)
class Job:
    """One piece of work.

    Attributes:
        name: Name of its files.
        function: At the top of a module, so that worker processes find it;
            called with robot, controller and the arguments.
        arguments: Plain data.
        cost: Estimated seconds, for the order of work and the bar.
        over_network: Ask both services over Zenoh; such jobs are done one
            after another, since controller and simulator keep two cores busy.
    """

    name: str
    function: Callable[..., Outcome]
    arguments: dict[str, Any] = field(default_factory=dict)
    cost: float = 10.0
    over_network: bool = False

    @property
    def function_name(self) -> str:
        """Where the function stands: 'module:name'."""
        return f"{self.function.__module__}:{self.function.__qualname__}"

    def fingerprint(self, robot: Robot) -> str:
        """What the stored result must have been made from.

        The program itself counts by its version only.
        """
        scenes = [path.read_text() for path in sorted(robot.path.parent.glob("*.xml"))]
        content = [
            self.function_name,
            self.arguments,
            self.over_network,
            __version__,
            robot.fingerprint,
            mujoco.__version__,
            scenes,
        ]
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Result:
    """A finished job.

    Attributes:
        rows: Plain data, one per run.
        arrays: Traces and weights by name.
        span: When it was done, begin and end [s] since 1970.
    """

    rows: list[dict[str, Any]]
    arrays: dict[str, Vector]
    span: Span

    def row(self, label: str) -> dict[str, Any]:
        """The row of that label.

        Args:
            label: Unique in the result.

        Raises:
            KeyError: If there is none.
        """
        for row in self.rows:
            if row["label"] == label:
                return row
        raise KeyError(label)

    def last_iteration(self) -> str:
        """Label of the last iteration that was run.

        Raises:
            SimulationError: If not even the first one was.
        """
        labels = [row["label"] for row in self.rows if row["label"].startswith("iteration")]
        if not labels:
            raise SimulationError(f"nothing was learned: {self.rows[-1].get('stopped')}")
        return str(labels[-1])

    def errors(self, name: str = "rms_error_m") -> Vector:
        """One measure of every run that has it, in order.

        Args:
            name: Of the measure; its unit is at the end of the name.
        """
        return np.array([row[name] for row in self.rows if row.get(name) is not None])

    def weights(self, label: str) -> list[float]:
        """Weights that a run used, (L,) [m/s^2].

        Args:
            label: Of the run.
        """
        return [float(value) for value in self.arrays[f"{label}/weights"][0]]


class Store:
    """Finished jobs of one robot in one folder.

    Attributes:
        folder: The folder.
    """

    def __init__(self, folder: Path, robot: Robot) -> None:
        """Open the folder, make it if need be.

        Args:
            folder: The folder.
            robot: The robot that the jobs are about.

        Raises:
            TsdError: If it cannot be written.
        """
        self.folder = folder
        self.robot = robot
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise TsdError(f"cannot write to {folder}: {error}; choose another --out") from error

    def load(self, job: Job) -> Result | None:
        """The result of a job that was finished with the same arguments."""
        described = self.folder / f"{job.name}.json"
        try:
            document = json.loads(described.read_text())
            if document["fingerprint"] != job.fingerprint(self.robot):
                return None
            with np.load(self.folder / f"{job.name}.npz") as stored:
                begin, end = document["span"]
                return Result(document["rows"], dict(stored), (begin, end))
        except (OSError, ValueError, KeyError, BadZipFile):
            return None  # not done, or half written: do it again

    def save(self, job: Job, outcome: Outcome, span: Span) -> Result:
        """Keep an outcome; the description comes last and says that all is there."""
        described = self.folder / f"{job.name}.json"
        # an older description must not be found beside newer arrays
        described.unlink(missing_ok=True)
        np.savez_compressed(self.folder / f"{job.name}.npz", **outcome.arrays)  # type: ignore[arg-type]
        document = {
            "fingerprint": job.fingerprint(self.robot),
            "function": job.function_name,
            "arguments": job.arguments,
            "span": span,
            "rows": outcome.rows,
        }
        part = self.folder / f"{job.name}.json.part"
        part.write_text(json.dumps(document))
        part.rename(described)
        return Result(outcome.rows, outcome.arrays, span)


def cores() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0))


def run_jobs(
    jobs: Sequence[Job], store: Store, report: Callable[[float, float], None]
) -> dict[str, Result]:
    """Do jobs on all cores and keep what they give.

    Args:
        jobs: The jobs, with unique names.
        store: Where results are kept.
        report: Called with (done, total) cost.

    Returns:
        Results by job name.
    """
    results: dict[str, Result] = {}
    total = sum(job.cost for job in jobs)
    done = 0.0
    report(done, total)
    for job, (outcome, span) in _finished(jobs, store.robot):
        results[job.name] = store.save(job, outcome, span)
        done += job.cost
        report(done, total)
    return results


_Finished = tuple[Job, tuple[Outcome, Span]]


def _finished(jobs: Sequence[Job], robot: Robot) -> Iterator[_Finished]:
    """Do jobs and hand them over as they end."""
    yield from _over_network([job for job in jobs if job.over_network], robot)
    local = [job for job in jobs if not job.over_network]
    # the longest first, so that no core is left with it at the end
    local.sort(key=lambda job: -job.cost)
    if not local:
        return
    # one thread per worker: matrices are small, and every core has a worker
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    path = str(robot.path)
    with ProcessPoolExecutor(
        cores(), mp_context=get_context("spawn"), initializer=_leave_interrupts
    ) as pool:
        futures = {pool.submit(_work, path, job): job for job in local}
        try:
            for future in as_completed(futures):
                yield futures[future], future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for worker in active_children():
                worker.terminate()  # a job may take a minute
            raise


def _over_network(jobs: Sequence[Job], robot: Robot) -> Iterator[_Finished]:
    if not jobs:
        return
    with start_services(robot) as (controller, learner):
        for job in jobs:
            yield job, _timed(job, robot, controller, learner=learner)


@lru_cache(maxsize=1)
def _workplace(path: str) -> tuple[Robot, Controller]:
    robot = load_robot(path)
    return robot, compile_controller(robot)


def _leave_interrupts() -> None:
    """Ctrl-C reaches all processes of a terminal; the first one ends the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _work(path: str, job: Job) -> tuple[Outcome, Span]:
    return _timed(job, *_workplace(path))


def _timed(job: Job, robot: Robot, controller: Any, **services: Any) -> tuple[Outcome, Span]:
    begin = time()
    outcome = job.function(robot, controller, **services, **job.arguments)
    return outcome, (begin, time())
