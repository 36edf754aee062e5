"""Jobs are done on all cores, those over the network one after another."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import lru_cache
from multiprocessing import active_children, get_context
from time import time
from typing import Any

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.controller.controller import Controller
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_casadi.single_thread import use_single_thread
from tsd_experiments.harness.duration import Span
from tsd_experiments.harness.job import Job, Result
from tsd_experiments.harness.outcome import Outcome
from tsd_experiments.harness.services import start_services
from tsd_experiments.harness.store import Store


def cores() -> int:
    """Count the processors that this process may use."""
    return len(os.sched_getaffinity(0))


def run_jobs(
    jobs: Sequence[Job], store: Store, report: Callable[[float, float], None]
) -> dict[str, Result]:
    """Do jobs on all cores and keep what they give.

    Args:
        jobs: The jobs, with unique names.
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
    use_single_thread()
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
    """Ignore Ctrl-C: it reaches all processes of a terminal, the first ends the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _work(path: str, job: Job) -> tuple[Outcome, Span]:
    return _timed(job, *_workplace(path))


def _timed(job: Job, robot: Robot, controller: Any, **services: Any) -> tuple[Outcome, Span]:
    begin = time()
    outcome = job.function(robot, controller, **services, **job.arguments)
    return outcome, (begin, time())
