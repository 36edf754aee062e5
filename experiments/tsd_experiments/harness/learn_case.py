"""The job that learns a case from repetition to repetition."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.database.database import Database
from tsd_casadi.exceptions import SimulationError
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.repetition.learn import Learner, learn
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_experiments.harness.case import Case
from tsd_experiments.harness.outcome import Outcome


def learn_case(
    robot: Robot,
    controller: WholeBodyController,
    case: dict[str, Any],
    *,
    rule: RuleName,
    iterations: int,
    first: Sequence[float] | None = None,
    seeds: Sequence[int] | None = None,
    learner: Learner | None = None,
) -> Outcome:
    """Learn a case from nothing, or from given weights.

    Args:
        case: Plain data of a ``Case``.
        iterations: N; there are N + 1 runs.
        first: Weights to start from, (L,) [m/s^2].
        seeds: One for each of the N + 1 runs; the case's for all by default.
        learner: Given to jobs over the network, where the controller is remote too;
            else it is learned in a database that is thrown away.

    Returns:
        Rows labelled 'iteration 0' ... The last row has 'stopped' if the robot
        fell or never settled. With a database of its own, by harmonic: what the
        filter of each iteration predicted at most and what the plain sum would
        leave, 'filter/predicted' and 'filter/plain', (N, harmonics), and what
        was left, 'filter/observed'; NaN where nothing could be told.
    """
    setting = Case.of(case)
    outcome = Outcome()
    filters: list[Contraction] = []
    with own_database() if learner is None else nullcontext(learner) as used:

        def keep(run: Run, notes: list[str]) -> None:
            label = f"iteration {len(outcome.rows)}"
            outcome.add(label, run, notes=notes, served=run.feedforward.iteration)
            if isinstance(used, Database):
                # of the iteration that is learned from this run
                filters.extend(used.entries()[0].contractions[:1])
            if label == "iteration 0" and run.laps:
                # one whole lap, for the encoding error
                outcome.arrays["lap/phase"] = run.laps[0].phase
                outcome.arrays["lap/feedback"] = run.laps[0].feedback[:1]

        try:
            learn(
                setting.simulator(robot),
                controller,
                [setting.motion],
                used,
                axes=setting.axes(robot),
                iterations=iterations,
                restart=True,
                rule=rule,
                laps=setting.laps,
                gains=setting.gains,
                first=None if first is None else setting.feedforward(robot, first, "nearest"),
                seed=setting.seed if seeds is None else seeds,
                transport="local" if learner is None else "zenoh",
                on_run=keep,
            )
        except SimulationError as error:
            outcome.rows.append({"label": "stopped", "stopped": str(error)})
        if isinstance(used, Database) and filters:
            for name in ("predicted", "plain"):
                rows = [getattr(each, name) for each in filters]
                outcome.arrays[f"filter/{name}"] = np.array(rows, dtype=float)  # None is NaN
            observed = used.entries()[0].observed_contractions()
            if observed is not None:
                outcome.arrays["filter/observed"] = observed
    return outcome


@contextmanager
def own_database() -> Iterator[Database]:
    """Open a database that is thrown away."""
    with tempfile.TemporaryDirectory() as folder, Database(Path(folder) / "case") as database:
        yield database
