"""The job that makes a robot stiffer and stiffer until it does not work."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_experiments.beyond.stiffness_or_feedforward.run_at import run_at
from tsd_experiments.harness.case import Case
from tsd_experiments.harness.outcome import Outcome, row_of

BISECTIONS = 3
# measured at the end of a run [s]
END = 1.0


def sweep(
    robot: Robot,
    controller: WholeBodyController,
    case: dict[str, Any],
    factors: Sequence[float],
    weights: list[float] | None = None,
    bisect: int = BISECTIONS,
) -> Outcome:
    """Make the robot stiffer until it does not work, then halve the interval.

    Args:
        factors: On P, rising.
        weights: Feedforward, (L,) [m/s^2].
        bisect: How often to halve, in the logarithm.

    Returns:
        One row per run, with 'factor', 'chatter' (RMS change of torque from tick
        to tick, as a share of its joint's limit, of the worst joint) and
        'stable': it neither fell nor needed safe torques.
    """
    outcome = Outcome()
    good, bad = 0.0, math.inf

    def works(factor: float) -> bool:
        run, _ = run_at(robot, controller, Case.of(case), factor, weights, ())
        stable = not run.fell and not run.failures
        label = f"factor {factor:.4g}"
        more = {"factor": factor, "chatter": _chatter(run, robot), "stable": stable}
        outcome.rows.append({"label": label, **row_of(run), **more})
        return stable

    for factor in factors:
        if not works(factor):
            bad = factor
            break
        good = factor
    if good > 0.0 and math.isfinite(bad):
        for _ in range(bisect):
            middle = math.sqrt(good * bad)
            good, bad = (middle, bad) if works(middle) else (good, middle)
    return outcome


def _chatter(run: Run, robot: Robot) -> float | None:
    torque = run.log["tau"][-round(1e3 * END) :] / robot.torque_limit
    if run.fell or len(torque) < 2:
        return None
    return float(np.sqrt(np.mean(np.diff(torque, axis=0) ** 2, axis=0)).max())
