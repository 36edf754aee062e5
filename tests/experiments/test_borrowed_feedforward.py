from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib import pyplot as plt

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.repetition.repetition import HOLD
from tsd_experiments.beyond.borrowed_feedforward.donors import shift_by_half_a_lap
from tsd_experiments.beyond.borrowed_feedforward.experiment import BorrowedFeedforward
from tsd_experiments.beyond.borrowed_feedforward.verdict import Verdict
from tsd_experiments.harness.experiment import Experiment
from tsd_experiments.harness.job import Result

coefficients = st.lists(st.floats(-1, 1), min_size=4, max_size=4)


@given(coefficients, coefficients)
def test_half_a_lap_late(sines: list[float], cosines: list[float]) -> None:
    basis, phase = PeriodicBasis(), 2 * np.pi * np.arange(100) / 100
    wanted = sum(
        (a * np.sin(n * phase) + b * np.cos(n * phase))
        for n, (a, b) in enumerate(zip(sines, cosines, strict=True))
    )
    weights = basis.fit(phase, np.array([wanted]))[0]
    late = basis.evaluate(phase, np.array([shift_by_half_a_lap(list(weights))]))[0]
    assert late == pytest.approx(np.roll(wanted, 50), abs=0.1)


@pytest.mark.parametrize(
    ("ungated", "dropped", "right"),
    [(2.0, 0.5, True), (2.0, None, False), (0.5, None, True), (0.5, 0.5, False), (None, 0.2, True)],
)
def test_decisions(ungated: float | None, dropped: float | None, right: bool) -> None:
    assert Verdict("ideal", "some", 1.0, ungated, 1.0, dropped).right is right


def test_the_wrong_sign_is_dropped_and_the_right_one_kept(
    finish_experiment: Callable[[Experiment], dict[str, Result]],
) -> None:
    experiment = BorrowedFeedforward(quick=True)
    done = finish_experiment(experiment)
    verdicts = {each.donor: each for each in experiment.verdicts(done)}
    assert all(each.right for each in verdicts.values())
    assert verdicts["5 cm instead of 3"].dropped_after is None
    flipped = verdicts["sign flipped"]
    # standing before the motion, before all of it was in use
    assert flipped.dropped_after == pytest.approx(-0.5, abs=0.1)
    assert flipped.gated == pytest.approx(flipped.none, rel=0.02)
    section = experiment.report(done)
    result = done["borrowed-ideal-with-sign_flipped"]
    # the last lap of the stored trace, independent of the run's own measure
    error, lap = (result.arrays[f"gated/{name}"] for name in ("error", "lap"))
    last = np.sqrt(np.mean(error[lap == lap.max()] ** 2))
    (row,) = [row for row in section.tables[0].rows if row[1] == "sign flipped"]
    assert float(row[4]) == pytest.approx(1e3 * last, rel=0.02)
    # faded out: nothing is fed forward at the end
    assert not result.arrays["gated/feedforward"][lap == lap.max()].any()
    dropped = result.row("gated")["dropped_at"]
    assert float(row[5]) == pytest.approx(dropped - HOLD, abs=0.005)
    for figure in section.figures:
        plt.close(figure.draw())
