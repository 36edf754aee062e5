"""Every run of every experiment in two files that any program reads."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tsd_experiments.harness.experiment import Done

RUNS = "runs.csv"
WEIGHTS = "weights.csv"
KEY = ("job", "label")
NO_MEASURES = {"robot_file"}  # a place on this machine


def write_measurements(done: Done, folder: Path) -> None:
    """Write what was measured in each run, and the feedforward that it used.

    ``runs.csv`` has a line per run and a column per measure, units at the end of
    the names; what a run has not is empty. ``weights.csv`` has the weights of the
    learned axis [m/s^2], in the order of the basis' centres.
    """
    runs = list(_runs(done))
    columns = dict.fromkeys(name for run in runs for name in run)
    with (folder / RUNS).open("w", newline="") as file:
        writer = csv.DictWriter(file, list(columns))
        writer.writeheader()
        writer.writerows(runs)
    weights = list(_weights(done))
    count = max((len(values) for _, _, values in weights), default=0)
    with (folder / WEIGHTS).open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow([*KEY, *(f"w{number}" for number in range(1, count + 1))])
        table.writerows([job, label, *values] for job, label, values in weights)


def _runs(done: Done) -> Iterator[dict[str, Any]]:
    for job, result in sorted(done.items()):
        for row in result.rows:
            plain = {
                name: value
                for name, value in row.items()
                if name not in NO_MEASURES and isinstance(value, bool | int | float | str)
            }
            yield {"job": job, "label": row["label"], **plain}


def _weights(done: Done) -> Iterator[tuple[str, str, list[float]]]:
    for job, result in sorted(done.items()):
        for row in result.rows:
            if f"{row['label']}/weights" in result.arrays:
                yield job, row["label"], result.weights(row["label"])
