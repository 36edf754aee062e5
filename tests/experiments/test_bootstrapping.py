from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib import pyplot as plt

from tsd_experiments.beyond.bootstrapping import Bootstrapping
from tsd_experiments.harness.experiment import Experiment
from tsd_experiments.harness.job import Result


def test_an_easier_squat_helps_a_hard_one(
    finish_experiment: Callable[[Experiment], dict[str, Result]],
) -> None:
    experiment = Bootstrapping(quick=True)
    done = finish_experiment(experiment)
    section = experiment.report(done)
    (table,) = section.tables
    cells = {row[0]: row[1:] for row in table.rows}
    nothing, helped = (cells[f"-30 %, from {start}, plain"] for start in ("nothing", "P = 50"))
    assert float(helped[0]) < 0.1 * float(nothing[0])
    # from the stored trace of the steady laps, not from the run's own measure
    result = done["bootstrapping--0.3-from-P50-plain"]
    error, lap = (result.arrays[f"iteration 0/{name}"] for name in ("error", "lap"))
    first = lap.max() - result.row("iteration 0")["laps_measured"] + 1
    steady = np.sqrt(np.mean(error[lap >= first] ** 2))
    assert float(helped[0]) == pytest.approx(1e3 * steady, rel=0.02)
    assert all(len(row) == len(table.head) for row in table.rows)
    for figure in section.figures:
        plt.close(figure.draw())
