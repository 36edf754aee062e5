from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from tsd_casadi import Feedforward, PeriodicBasis, Run, Squat
from tsd_casadi.exceptions import InvalidValue
from tsd_clients.logs.log_file import check_log_path, save_log


@pytest.fixture
def run() -> Run:
    rng = np.random.default_rng(0)
    return Run(
        robot="hermes_lower",
        motion=Squat(0.03, 0.25),
        axes=("com.z", "com.x"),
        feedforward=Feedforward.zero(("com.z",), PeriodicBasis()),
        gains={"P": [1.0], "D": [1.0]},
        settings={},
        log={
            "time": np.arange(3) * 1e-3,
            "lap": np.array([-1, 0, 0]),
            "measured": np.array([False, True, True]),
            "missed": np.zeros(3, dtype=int),
            "tick_us": np.ones(3),
            "true_error": rng.normal(size=(3, 2)),
            "feedback": rng.normal(size=(3, 2)),
            "error": rng.normal(size=(3, 2)),
            "tau": rng.normal(size=(3, 2)).astype(np.float32),
        },
        laps=[],
        laps_run=1,
        steady=True,
        fell=False,
        vetoes=[],
        failures={},
        model="0123",
    )


def test_arrays_come_back_as_they_were(run: Run, tmp_path: Path) -> None:
    save_log(run, tmp_path / "log.npz")
    with np.load(tmp_path / "log.npz", allow_pickle=False) as saved:
        assert set(saved) == {*run.log, "axes", "robot", "model", "summary"}
        assert tuple(saved["axes"]) == run.axes
        assert (str(saved["robot"]), str(saved["model"])) == (run.robot, "0123")
        for name, values in run.log.items():
            np.testing.assert_array_equal(saved[name], values)
            assert saved[name].dtype == values.dtype


def test_csv_has_a_line_a_tick_and_every_digit(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "log.CSV"
    save_log(run, path)
    with path.open(newline="") as file:
        header, *rows = list(csv.reader(file))
    assert header[:5] == ["time", "lap", "measured", "missed", "tick_us"]
    assert header[-4:] == ["error[com.z]", "error[com.x]", "tau[0]", "tau[1]"]
    assert [row[1:3] for row in rows] == [["-1", "0"], ["0", "1"], ["0", "1"]]
    columns = dict(zip(header, zip(*rows, strict=True), strict=True))
    error = np.array([columns["error[com.z]"], columns["error[com.x]"]], dtype=float).T
    np.testing.assert_array_equal(error, run.log["error"])
    tau = np.array([columns["tau[0]"], columns["tau[1]"]], dtype=np.float32).T
    np.testing.assert_array_equal(tau, run.log["tau"])


@pytest.mark.parametrize("name", ["log", "log.txt", "log.csv.gz", ".csv"])
def test_other_endings_are_refused_by_name(run: Run, tmp_path: Path, name: str) -> None:
    with pytest.raises(InvalidValue, match=rf"{name}.*ends in \.csv or \.mcap or \.npz"):
        check_log_path(tmp_path / name)
    with pytest.raises(InvalidValue):
        save_log(run, tmp_path / name)
    assert list(tmp_path.iterdir()) == []
