from __future__ import annotations

import json
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


def run_of(errors: list[float], measured: list[bool] | None = None, **changes: Any) -> Run:
    """A run whose true error is twice, and whose feedback minus 50 times the error."""
    error = np.array(errors)
    count = len(error)
    log = {
        "time": np.arange(count) * 1e-3,
        "measured": np.ones(count, dtype=bool) if measured is None else np.array(measured),
        "error": error,
        "true_error": 2 * error,
        "feedback": -50 * error,
        "tick_us": np.arange(1.0, count + 1),
    }
    lap = Lap(np.arange(4.0), np.zeros((1, 4)))
    values: dict[str, Any] = {
        "robot": "hermes_lower",
        "motion": Squat(0.03, 0.25),
        "feedforward": Feedforward.zero(("com.z",), PeriodicBasis()),
        "gains": {"P": [50.0], "D": [14.0]},
        "settings": {"model_error": 0.1, "p_scale": 1.0, "transport": "local", "seed": 3},
        "log": log,
        "laps": [lap, lap],
        "laps_run": 3,
        "steady": True,
        "fell": False,
        "failures": {},
    }
    return Run(**{**values, **changes})


@given(errors=ERRORS)
def test_measures_are_those_of_numpy(errors: list[float]) -> None:
    run, error = run_of(errors), np.array(errors)
    assert run.rms_error == pytest.approx(np.sqrt(np.mean(error**2)))
    assert run.ac_rms_error == pytest.approx(np.std(error), abs=1e-12)
    assert run.peak_error == np.max(np.abs(error))
    assert run.true_rms_error == pytest.approx(2 * run.rms_error)
    assert run.mean_abs_feedback == pytest.approx(50 * np.mean(np.abs(error)))


@given(errors=ERRORS)
def test_rms_squared_is_mean_squared_plus_ac_squared(errors: list[float]) -> None:
    run = run_of(errors)
    assert run.rms_error**2 == pytest.approx(np.mean(errors) ** 2 + run.ac_rms_error**2, abs=1e-15)
    assert run.peak_error >= run.rms_error - 1e-15
    assert run.rms_error >= run.ac_rms_error - 1e-15


def test_only_measured_ticks_count() -> None:
    run = run_of([9.0, 1.0, -1.0, 9.0], [False, True, True, False])
    assert (run.rms_error, run.peak_error, run.ac_rms_error) == (1.0, 1.0, 1.0)
    assert run.true_rms_error == 2.0
    assert run.mean_abs_feedback == 50.0
    assert run.ticks == 4


def test_tick_times_are_over_all_ticks() -> None:
    run = run_of([0.0] * 101, [False] * 101)
    assert run.tick_us == {"p50": 51.0, "p99": 100.0, "max": 101.0}


def test_errors_are_what_a_database_entry_needs() -> None:
    errors = run_of([1e-3, -1e-3]).errors()
    assert errors == {
        "rms_error_m": 1e-3,
        "peak_error_m": 1e-3,
        "ac_rms_error_m": 1e-3,
        "true_rms_error_m": 2e-3,
        "mean_abs_feedback": 0.05,
    }
    assert all(type(value) is float for value in errors.values())


def test_summary_is_plain_json_with_units_in_the_names() -> None:
    run = run_of([1e-3, -2e-3], failures={"infeasible": 2}, laps_run=7)
    summary = json.loads(json.dumps(run.summary()))
    assert summary["amplitude_m"] == 0.03
    assert summary["frequency_hz"] == 0.25
    assert (summary["robot"], summary["task"]) == ("hermes_lower", "squat")
    assert (summary["model_error"], summary["seed"], summary["transport"]) == (0.1, 3, "local")
    assert (summary["feedforward"], summary["iteration"]) == ("none", 0)
    assert (summary["laps_run"], summary["laps_measured"]) == (7, 2)
    assert summary["failures"] == {"infeasible": 2}
    assert summary["rms_error_m"] == run.rms_error
    assert "log" not in summary


def test_every_quantity_of_the_log_is_described() -> None:
    assert set(run_of([0.0]).log) <= set(LOG_FIELDS)
    assert all(field.meaning for field in LOG_FIELDS.values())
