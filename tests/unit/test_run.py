from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tsd_casadi import Feedforward, PeriodicBasis, Squat
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.repetition.run import Run

ERRORS = st.lists(st.floats(-0.1, 0.1), min_size=1, max_size=50)
P = [50.0, 100.0]


def run_of(errors: list[float], measured: list[bool] | None = None, **changes: Any) -> Run:
    """A run whose true error is twice, and whose feedback minus 50 times the error of com.z.

    The error of torso.rz is three times that of com.z; com.x only moves.
    """
    z = np.array(errors)
    error = np.column_stack((z, 3 * z, np.full(len(z), 7.0)))
    count = len(z)
    log = {
        "time": np.arange(count) * 1e-3,
        "measured": np.ones(count, dtype=bool) if measured is None else np.array(measured),
        "error": error,
        "true_error": 2 * error,
        "feedback": -50 * error,
        "tick_us": np.arange(1.0, count + 1),
        "missed": np.zeros(count, dtype=int),
    }
    lap = Lap(np.arange(4.0), np.zeros((2, 4)))
    values: dict[str, Any] = {
        "robot": "hermes_lower",
        "motion": Squat(0.03, 0.25),
        "axes": ("com.z", "torso.rz", "com.x"),
        "feedforward": Feedforward.zero(("com.z", "torso.rz"), PeriodicBasis()),
        "gains": {"P": P, "D": [14.0, 20.0]},
        "settings": {"model_error": 0.1, "p_scale": 1.0, "transport": "local", "seed": 3},
        "log": log,
        "laps": [lap, lap],
        "laps_run": 3,
        "steady": True,
        "fell": False,
        "vetoes": [],
        "failures": {},
    }
    return Run(**{**values, **changes})


@given(errors=ERRORS)
def test_measures_are_those_of_numpy_axis_by_axis(errors: list[float]) -> None:
    run = run_of(errors)
    assert list(run.errors) == ["com.z", "torso.rz"] == list(run.learned)
    for axis, factor in (("com.z", 1.0), ("torso.rz", 3.0)):
        found, error = run.errors[axis], factor * np.array(errors)
        assert found.rms == pytest.approx(np.sqrt(np.mean(error**2)))
        assert found.ac_rms == pytest.approx(np.std(error), abs=1e-12)
        assert found.peak == np.max(np.abs(error))
        assert found.true_rms == pytest.approx(2 * found.rms)
        assert found.mean_abs_feedback == pytest.approx(50 * np.mean(np.abs(error)))


@given(errors=ERRORS)
def test_rms_squared_is_mean_squared_plus_ac_squared(errors: list[float]) -> None:
    found = run_of(errors).errors["com.z"]
    assert found.ac_rms is not None
    assert found.peak is not None
    assert found.rms**2 == pytest.approx(np.mean(errors) ** 2 + found.ac_rms**2, abs=1e-15)
    assert found.peak >= found.rms - 1e-15
    assert found.rms >= found.ac_rms - 1e-15


@given(errors=ERRORS)
def test_axes_are_ranked_by_stiffness_times_error(errors: list[float]) -> None:
    run = run_of(errors)
    rms = run.errors["com.z"].rms
    expected = math.sqrt(((P[0] * rms) ** 2 + (P[1] * 3 * rms) ** 2) / 2)
    assert run.rank == pytest.approx(expected)


def test_only_measured_ticks_count() -> None:
    run = run_of([9.0, 1.0, -1.0, 9.0], [False, True, True, False])
    found = run.errors["com.z"]
    assert (found.rms, found.peak, found.ac_rms, found.true_rms) == (1.0, 1.0, 1.0, 2.0)
    assert found.mean_abs_feedback == 50.0
    assert run.ticks == 4
    np.testing.assert_array_equal(run.measured("error")[:, 0], [1.0, -1.0])


def test_axes_are_found_by_name() -> None:
    run = run_of([1.0, 2.0])
    np.testing.assert_array_equal(run.along("error", "torso.rz"), [3.0, 6.0])
    np.testing.assert_array_equal(run.along("error", "com.x"), [7.0, 7.0])
    with pytest.raises(ValueError, match="not in tuple"):
        run.along("error", "com.y")


def test_what_was_not_measured_is_no_number_and_null() -> None:
    run = run_of([9.0, 9.0], [False, False])
    assert math.isnan(run.errors["com.z"].rms)
    assert math.isnan(run.rank)
    summary = json.loads(json.dumps(run.summary(), allow_nan=False))
    assert summary["errors"]["com.z"]["rms"] is None
    assert summary["rank"] is None


def test_a_true_error_that_nobody_knows_is_unknown() -> None:
    run = run_of([1.0, 2.0])
    run.log["true_error"][:] = math.nan
    assert run.errors["torso.rz"].true_rms is None
    assert run.errors["torso.rz"].rms > 0


def test_tick_times_are_over_all_ticks() -> None:
    run = run_of([0.0] * 101, [False] * 101)
    assert run.tick_us == {"p50": 51.0, "p99": 100.0, "max": 101.0}


def test_errors_are_plain_numbers() -> None:
    plain = run_of([1e-3, -1e-3]).errors["com.z"].plain()
    assert plain == {
        "rms": 1e-3,
        "peak": 1e-3,
        "ac_rms": 1e-3,
        "mean_abs_feedback": 0.05,
        "true_rms": 2e-3,
    }
    assert all(type(value) is float for value in plain.values())


def test_summary_is_plain_json_with_a_unit_for_each_axis() -> None:
    run = run_of([1e-3, -2e-3], failures={"infeasible": 2}, laps_run=7, vetoes=["it was worse"])
    summary = json.loads(json.dumps(run.summary()))
    assert summary["parameters"] == {"amplitude": 0.03, "frequency": 0.25, "height": 0.0}
    assert (summary["robot"], summary["motion"]) == ("hermes_lower", "squat")
    assert (summary["model_error"], summary["seed"], summary["transport"]) == (0.1, 3, "local")
    assert (summary["feedforward"], summary["iteration"]) == ("none", 0)
    assert (summary["laps_run"], summary["laps_measured"]) == (7, 2)
    assert summary["failures"] == {"infeasible": 2}
    assert summary["vetoes"] == ["it was worse"]
    units = {axis: error["unit"] for axis, error in summary["errors"].items()}
    assert units == {"com.z": "m", "torso.rz": "rad"}
    assert summary["errors"]["torso.rz"]["rms"] == run.errors["torso.rz"].rms
    assert "log" not in summary


def test_it_says_how_well_each_axis_did() -> None:
    assert repr(run_of([1e-3, -1e-3])) == (
        "<Run of hermes_lower: squat amplitude=0.03 frequency=0.25 height=0; feedforward none; "
        "com.z 1.0000 mm, torso.rz 3.0000 mrad>"
    )
    assert "fell after 2 ticks" in repr(run_of([1.0, 1.0], fell=True))


def test_every_quantity_of_the_log_is_described() -> None:
    assert set(run_of([0.0]).log) <= set(LOG_FIELDS)
    assert all(field.meaning for field in LOG_FIELDS.values())
