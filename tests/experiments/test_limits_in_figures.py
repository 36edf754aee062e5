"""The figure of a run marks when which joint was on a limit."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tsd_casadi import Controller, Robot, Run, Squat
from tsd_casadi.repetition.compensator import Compensator, Moment
from tsd_clients import MujocoSimulator
from tsd_experiments.harness.job import Result
from tsd_experiments.harness.outcome import TRACE_STEP, Outcome
from tsd_experiments.report.curve import Curve
from tsd_experiments.report.drawing import draw_tracking

KNEE = "L_KFE"
ROW = f"joint_position.{KNEE}"


class Stop(Compensator):
    """In the way of the knee, and when the controller named it."""

    def __init__(self, robot: Robot) -> None:
        self.place = robot.joint_names.index(KNEE)
        self.angle = robot.home.q[7 + self.place] + 0.02
        self.named: list[bool] = []

    def before(self, moment: Moment) -> None:
        moment.command["limits.position_upper"][self.place] = self.angle

    def after(self, moment: Moment) -> None:
        assert moment.tick is not None
        self.named.append(ROW in moment.tick.active)


@pytest.fixture(scope="module")
def stopped(robot: Robot, controller: Controller) -> tuple[Run, Stop]:
    stop = Stop(robot)
    run = MujocoSimulator(robot).run(controller, Squat(0.02, 1.0), laps=2, compensators=[stop])
    return run, stop


def test_a_run_tells_when_which_limit_was_met(stopped: tuple[Run, Stop]) -> None:
    run, stop = stopped
    assert any(stop.named) and not all(stop.named)
    np.testing.assert_array_equal(run.limited[ROW], stop.named)
    assert set(run.at_limits) == {KNEE}


def test_the_figure_marks_it(stopped: tuple[Run, Stop]) -> None:
    curve = Curve.of("none", stopped[0], "none")
    panels = draw_tracking([curve, dataclasses.replace(curve, style="learned")], "squat").axes
    assert [label.get_text() for label in panels[-1].get_yticklabels()] == list(curve.limited)
    marked = np.concatenate(
        [path.vertices[:, 0] for bars in panels[-1].collections for path in bars.get_paths()]
    )
    when = curve.signals["time"][curve.limited[ROW]]
    assert marked.min() == pytest.approx(when.min(), abs=2e-3)
    assert marked.max() == pytest.approx(when.max(), abs=2e-3)


def test_without_limits_there_is_no_such_panel(stopped: tuple[Run, Stop]) -> None:
    curve = dataclasses.replace(Curve.of("none", stopped[0], "none"), limited={})
    assert len(draw_tracking([curve, curve], "squat").axes) == 3


def test_experiments_keep_it(stopped: tuple[Run, Stop]) -> None:
    outcome = Outcome()
    outcome.add("run", stopped[0])
    curve = Curve.stored("none", Result(outcome.rows, outcome.arrays, (0.0, 1.0)), "run", "none")
    assert list(curve.limited) == list(stopped[0].limited)
    kept = curve.limited[ROW]
    assert len(kept) == len(curve.signals["time"])
    assert kept.sum() >= stopped[0].limited[ROW].sum() / TRACE_STEP
