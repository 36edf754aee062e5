"""The jobs that compare methods: as learned, transferred, pushed and generalised."""

from __future__ import annotations

import numpy as np

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.repetition.repetition import HOLD
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_clients.simulator.disturbances import Push
from tsd_experiments.comparison.measure import describe, drive, measure
from tsd_experiments.comparison.prepare import prepare, prepare_generalized
from tsd_experiments.comparison.scenario import SCENARIOS
from tsd_experiments.harness.outcome import Outcome

IMPULSE = (0.0, 0.0, -10.0)  # N s
PUSH_DURATION = 0.1  # s
SEEN = 2.0  # s after the push


def compare(
    robot: Robot, controller: WholeBodyController, method: str, scenario: str, transfers: list[str]
) -> Outcome:
    """Prepare one method, run it as learned and transferred, then push it.

    Args:
        method: Key of ``METHODS``.
        scenario: Key of ``SCENARIOS``.
        transfers: What to measure; 'none' is the first.

    Returns:
        One row per transfer and one labelled 'push'; the deflection by the
        push over time.
    """
    setting = SCENARIOS[scenario]
    alternative, bench = prepare(robot, controller, method, setting)
    outcome = Outcome()
    calm: Run | None = None
    for name in transfers:
        run = drive(alternative, bench, setting, setting.transfers[name])
        row = describe(run, alternative, setting)
        outcome.rows.append({"label": name, "method": method, **row})
        calm = calm or run
    assert calm is not None  # the first transfer is the squat itself
    # in the second lap, where the robot is lowest
    start = HOLD + 1.25 / setting.squat.frequency
    push = Push(start, PUSH_DURATION, IMPULSE)
    pushed = drive(alternative, bench, setting, setting.squat, [push])
    count = min(calm.ticks, pushed.ticks)
    time = calm.log["time"][:count] - start
    away, usual = (run.along("true_error", run.axes[0])[:count] for run in (pushed, calm))
    deflection = away - usual
    peak = float(np.abs(deflection[time >= 0]).max(initial=0.0))
    outcome.rows.append({"label": "push", "deflection_m": peak, "fell": pushed.fell})
    window = (time >= -0.1) & (time < SEEN)
    outcome.arrays["push/time"] = time[window]
    outcome.arrays["push/deflection"] = deflection[window]
    return outcome


def compare_generalized(
    robot: Robot, controller: WholeBodyController, method: str, scenario: str
) -> Outcome:
    """Learn at 2, 4, 6 and 8 cm, generalise to 5 cm.

    Args:
        method: Key of ``GENERALIZED``.
        scenario: Key of ``SCENARIOS``.

    Returns:
        One row labelled 'generalised'.
    """
    setting = SCENARIOS[scenario]
    alternative, bench = prepare_generalized(robot, controller, method, setting)
    row = measure(alternative, bench, setting, setting.transfers["amplitude"])
    return Outcome([{"label": "generalised", "method": method, **row}])
