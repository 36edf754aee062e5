from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tsd_experiments.beyond.two_parameters.experiment import TwoParameters
from tsd_experiments.beyond.two_parameters.grid import Grid
from tsd_experiments.harness.experiment import Experiment
from tsd_experiments.harness.job import Result

CORNERS = ((0.03, 0.8), (0.03, 1.0), (0.05, 0.8), (0.05, 1.0))
HELD_OUT = ((0.035, 0.85), (0.045, 0.95), (0.04, 0.85))


class Small(TwoParameters):
    grid = Grid(
        learned=(*CORNERS, (0.04, 0.9)),
        held_out=HELD_OUT,
        driven=HELD_OUT[:2],
        shown=HELD_OUT[:2],
        repeated=CORNERS[:1],
        iterations=1,
        draws=2,
    )


def test_small_grid(finish_experiment: Callable[[Experiment], dict[str, Result]]) -> None:
    experiment = Small(quick=False)
    done = finish_experiment(experiment)
    section = experiment.report(done)
    names = [f"{amplitude:g}-{frequency:g}" for amplitude, frequency in HELD_OUT[:2]]
    entries = [done[f"grid-entry-{name}"] for name in names]
    none, direct = (np.array([e.rows[i]["ac_rms_error_m"] for e in entries]) for i in (0, -1))
    generalized = np.array(
        [done[f"grid-generalised-{name}"].row("replay")["ac_rms_error_m"] for name in names]
    )
    rms = np.linalg.norm(generalized) / np.linalg.norm(direct)
    assert section.goals[0].measured == pytest.approx(rms)
    assert (generalized < 0.2 * none).all()
    again, entry = (done[f"grid-{kind}-0.03-0.8"] for kind in ("again", "entry"))
    assert again.last_iteration() == "iteration 1"
    assert again.weights("iteration 1") != entry.weights("iteration 1")
    assert all(0 <= share <= 1 for share in experiment.predictions(done).coverage(CORNERS))
    coverage = section.goals[2].measured
    assert coverage is not None and np.isfinite(coverage)
    for figure in section.figures:
        figure.draw().savefig("/dev/null", format="png")
