from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tsd_clients.reproduction import parameter_grid
from tsd_clients.reproduction.experiment import Experiment
from tsd_clients.reproduction.jobs import Result
from tsd_clients.reproduction.parameter_grid import ParameterGrid

CORNERS = ((0.03, 0.8), (0.03, 1.0), (0.05, 0.8), (0.05, 1.0))
HELD_OUT = ((0.035, 0.85), (0.045, 0.95), (0.04, 0.85))


def test_short_form(
    finish_experiment: Callable[[Experiment], dict[str, Result]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name, value in {
        "LEARNED": (*CORNERS, (0.04, 0.9)),
        "CORNERS": CORNERS,
        "HELD_OUT": HELD_OUT,
        "DRIVEN": HELD_OUT[:1],
        "ITERATIONS": 1,
        "DRAWS": 2,
    }.items():
        monkeypatch.setattr(parameter_grid, name, value)
    experiment = ParameterGrid(quick=False)
    done = finish_experiment(experiment)
    section = experiment.report(done)
    direct = done["grid-entry-0.035-0.85"].rows[-1]["ac_rms_error_m"]
    generalised = done["grid-generalised-0.035-0.85"].row("replay")["ac_rms_error_m"]
    assert section.goals[0].measured == pytest.approx(generalised / direct)
    assert generalised < 0.2 * done["grid-entry-0.035-0.85"].rows[0]["ac_rms_error_m"]
    assert all(0 <= share <= 1 for share in experiment.coverage(done, CORNERS))
    coverage = section.goals[2].measured
    assert coverage is not None and np.isfinite(coverage)
    for figure in section.figures:
        figure.draw().savefig("/dev/null", format="png")
