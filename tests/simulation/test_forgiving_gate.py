"""The bounded form of ``python -m benchmarks.gate`` and ``python -m benchmarks.true_error``."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from benchmarks import true_error
from benchmarks.gate import BACK, DROPPED, HARMFUL, Bench, claims, too_much
from benchmarks.harmful_terms import harmful_terms
from tsd_experiments.harness.case import Case


@pytest.fixture(scope="module")
def bench() -> Bench:
    return Bench.prepare(Case(frequency=0.5, hardware=("all",)), iterations=2)


@pytest.mark.long
def test_the_term_is_back_two_laps_after_a_disturbance(bench: Bench) -> None:
    rng, stood = np.random.default_rng(1), []
    while len(stood) < 4:
        run = bench.disturbed(rng)
        if not run["fell"]:
            stood.append(run)
    assert all(each["back"] <= BACK for each in stood), stood


@pytest.mark.long
@pytest.mark.parametrize("kind", ["sign flipped", "2.2 times", "a pulse down", "noise of a lap"])
def test_what_harms_is_dropped_within_a_lap(bench: Bench, kind: str) -> None:
    row = bench.harmful(kind, harmful_terms(bench.fits)[kind])
    assert row["ungated"] > HARMFUL * row["none"]
    assert row["dropped"] <= DROPPED
    assert not row["in_use"]
    assert row["gated"] == pytest.approx(row["none"], rel=0.05)


@pytest.mark.long
def test_what_is_said_of_the_error_without_the_term_is_right(bench: Bench) -> None:
    # predicted at the usual gains, tried at soft ones, where a prediction is no more than a guess
    stiff, _, soft = claims(bench.fits, bench)
    assert stiff["said"] == pytest.approx(stiff["measured"], rel=0.05)
    assert soft["said"] == pytest.approx(soft["measured"], rel=0.05)


@pytest.mark.long
def test_at_soft_gains_what_harms_is_found_out_by_a_lap_without_it(bench: Bench) -> None:
    row = too_much(bench.fits, bench)
    assert row["ungated"] > HARMFUL * row["none"]
    assert not row["in_use"]
    assert row["gated"] == pytest.approx(row["none"], rel=0.05)


@pytest.mark.long
def test_learning_may_make_the_true_error_larger(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["true_error", "--seeds", "2", "--iterations", "1"])
    true_error.main()
    assert "of 2, median" in " ".join(capsys.readouterr().out.split())
