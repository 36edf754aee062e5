from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from tsd_experiments.harness.job import Result
from tsd_experiments.harness.measurements import write_measurements

SPAN = (0.0, 1.0)
DONE = {
    "two": Result([{"label": "push", "recovery_s": 0.1 + 0.2, "fell": False}], {}, SPAN),
    "one": Result(
        [
            {"label": "iteration 0", "rms_error_m": 1e-3, "gains": {"P": [50.0]}, "notes": []},
            {"label": "iteration 1", "rms_error_m": None},
            {"label": "stopped", "stopped": "the robot fell, sorry"},
        ],
        {
            "iteration 0/weights": np.zeros((1, 3)),
            "iteration 1/weights": np.array([[1 / 3, -2.0, 1e-17]]),
            "iteration 1/error": np.ones(4),
        },
        SPAN,
    ),
}


def read(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_every_run_has_a_line_with_what_was_measured(tmp_path: Path) -> None:
    write_measurements(DONE, tmp_path)
    rows = read(tmp_path / "runs.csv")
    assert [(row["job"], row["label"]) for row in rows] == [
        ("one", "iteration 0"),
        ("one", "iteration 1"),
        ("one", "stopped"),
        ("two", "push"),
    ]
    assert float(rows[0]["rms_error_m"]) == 1e-3
    assert rows[1]["rms_error_m"] == ""
    assert rows[2]["stopped"] == "the robot fell, sorry"
    assert float(rows[3]["recovery_s"]) == 0.1 + 0.2
    assert rows[3]["fell"] == "False"
    assert not {"gains", "notes"} & rows[0].keys()


def test_weights_are_exact(tmp_path: Path) -> None:
    write_measurements(DONE, tmp_path)
    rows = read(tmp_path / "weights.csv")
    assert [row["label"] for row in rows] == ["iteration 0", "iteration 1"]
    assert [float(rows[1][name]) for name in ("w1", "w2", "w3")] == [1 / 3, -2.0, 1e-17]


def test_nothing_done_gives_headings(tmp_path: Path) -> None:
    write_measurements({}, tmp_path)
    assert (tmp_path / "weights.csv").read_text().strip() == "job,label"
    assert read(tmp_path / "runs.csv") == []
