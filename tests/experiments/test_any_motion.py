from __future__ import annotations

import json

import numpy as np
import pytest
from matplotlib import pyplot as plt

from tsd_casadi import Controller, Robot
from tsd_experiments.beyond.any_motion.learn_motion import learn_motion
from tsd_experiments.beyond.any_motion.measures import (
    OverSeeds,
    measure_of,
    times_smaller,
    together_by_alone,
)
from tsd_experiments.beyond.any_motion.pictures import draw_motions
from tsd_experiments.harness.job import Result
from tsd_experiments.harness.outcome import Outcome

PARAMETERS = {"amplitude": 0.01, "frequency": 1.0}


def as_stored(outcome: Outcome) -> Result:
    rows = json.loads(json.dumps(outcome.rows, allow_nan=False))
    return Result(rows, outcome.arrays, (0.0, 1.0))


@pytest.fixture(scope="module")
def circle(robot: Robot, controller: Controller) -> Result:
    return as_stored(learn_motion(robot, controller, "circle", PARAMETERS, iterations=2))


def test_all_axes_are_learned_together(circle: Result) -> None:
    first = circle.rows[0]
    assert first["axes"] == ["com.x", "com.y", "com.z"]
    for axis in first["axes"]:
        before, after = (measure_of(row, axis) for row in (first, circle.rows[2]))
        assert after < before / 30


def test_measures_are_those_of_the_traces(circle: Result) -> None:
    for axis, place in (("com.x", "error"), ("com.z", "error/com.z")):
        error = circle.arrays[f"iteration 0/{place}"]
        lap = circle.arrays["iteration 0/lap"]
        rms = float(np.sqrt(np.mean(error[lap == lap.max()].astype(float) ** 2)))
        assert measure_of(circle.row("iteration 0"), axis) == pytest.approx(rms, rel=0.05)


def test_one_axis_alone_and_the_other_only_moves(robot: Robot, controller: Controller) -> None:
    alone = as_stored(learn_motion(robot, controller, "circle", PARAMETERS, alone=1, iterations=1))
    row = alone.row("iteration 1")
    assert row["axes"] == ["com.y", "com.x"]
    assert row["rms_error_m"] > 0
    assert "com.x/rms_error_m" not in row
    assert alone.arrays["iteration 1/weights"].shape[0] == 1


def test_the_extremes_are_where_the_axis_is_farthest(robot: Robot, circle: Result) -> None:
    left, right = (robot.center_of_mass(q)[0] for q in circle.arrays["extremes"])
    assert left - right == pytest.approx(0.02, abs=1e-3)


def test_ratios_over_seeds() -> None:
    def result(*errors: float) -> Result:
        rows = [
            {
                "label": f"iteration {number}",
                "axes": ["com.z", "torso.rz"],
                "torso.rz/rms_error_rad": e,
            }
            for number, e in enumerate(errors)
        ]
        return Result(rows, {}, (0.0, 1.0))

    results = [result(8.0, 2.0), result(9.0, 1.0), result(10.0, 2.0)]
    ratios = times_smaller(results, "torso.rz", 1)
    assert (ratios.median, ratios.worst) == (5.0, 4.0)
    assert ratios.text() == "5 / 4"
    others = [result(8.0, 1.0)] * 3
    assert together_by_alone(results, others, "torso.rz").worst == 2.0
    assert OverSeeds([1234.5]).text() == "1234"


@pytest.mark.parametrize("pictured", [True, False])
def test_the_figure(circle: Result, pictured: bool) -> None:
    frames = np.zeros((2, 4, 3, 3), dtype=np.uint8) if pictured else None
    drawn = draw_motions({"circle": circle}, lambda motion, result: frames)
    assert len(drawn.axes) == 2 + pictured
    path = drawn.axes[-2]
    assert path.get_xlabel() == "CoM x [mm]" and path.get_ylabel() == "CoM y [mm]"
    assert np.ptp(path.lines[-1].get_xdata()) == pytest.approx(20.0, rel=0.01)
    plt.close(drawn)
