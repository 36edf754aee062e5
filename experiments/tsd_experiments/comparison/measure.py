"""Runs with a method, and what is compared of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.run import Run
from tsd_clients.simulator.disturbances import Disturbance
from tsd_experiments.comparison.bench import Alternative, Bench
from tsd_experiments.comparison.scenario import Scenario
from tsd_experiments.harness.outcome import measures_of


def drive(
    alternative: Alternative,
    bench: Bench,
    scenario: Scenario,
    squat: Squat,
    disturbances: Sequence[Disturbance] = (),
) -> Run:
    """Run a squat once with a method."""
    return bench.simulator.run(
        alternative.controller,
        squat,
        axes=squat.axes(bench.robot),
        feedforward=alternative.feedforward,
        gains=scenario.gains,
        compensators=alternative.compensators,
        disturbances=disturbances,
        seed=scenario.seed,
    )


def measure(
    alternative: Alternative, bench: Bench, scenario: Scenario, squat: Squat
) -> dict[str, Any]:
    """Run a squat once with a method and tell what is compared of it."""
    return describe(drive(alternative, bench, scenario, squat), alternative, scenario)


def describe(run: Run, alternative: Alternative, scenario: Scenario) -> dict[str, Any]:
    """Write what is compared of a run as plain data, None where nothing was measured."""
    true_error = run.measured("true_error")[:, 0]
    values = {
        **measures_of(run),
        "true_ac_rms_error_m": float(true_error.std()) if true_error.size else math.nan,
    }
    return {
        "scenario": scenario.name,
        **run.motion.parameters,
        **{
            name: value if value is not None and math.isfinite(value) else None
            for name, value in values.items()
        },
        "laps_run": run.laps_run,
        "steady": run.steady,
        "fell": run.fell,
        "failures": run.failures,
        "numbers_learned": alternative.numbers_learned,
        "repetitions": alternative.repetitions,
    }
