"""What the demonstration has to show."""

from __future__ import annotations

from collections.abc import Mapping

from tsd_casadi.repetition.run import Run
from tsd_experiments.demo.plan import REUSED, Plan, label_of
from tsd_experiments.harness.section import Goal


def goals_of(runs: Mapping[str, Run], plan: Plan) -> list[Goal]:
    """Measure what the method promises, as ratios of two runs of this demonstration."""
    none, constant, perfect, first, second, reduced = (
        runs[label_of(plan.amplitude, what)]
        for what in (
            "none",
            "constant",
            "perfect model, none",
            "learned, iteration 1",
            "learned, iteration 2",
            "P/5, learned, iteration 1",
        )
    )
    generalized, direct, nearest = (
        runs[label_of(plan.queried, what)]
        for what in ("generalised", "learned, iteration 2", REUSED)
    )
    ac_none = none.ac_rms_error
    return [
        Goal("RMS error, none / one iteration", ">= 80", none.rms_error / first.rms_error),
        Goal("AC error, none / one iteration", ">= 5", ac_none / first.ac_rms_error),
        Goal("AC error, none / two iterations", ">= 25", ac_none / second.ac_rms_error),
        Goal(
            "mean |feedback|, none / one iteration",
            ">= 80",
            none.mean_abs_feedback / first.mean_abs_feedback,
        ),
        Goal("RMS error, none at P / learned at P/5", ">= 20", none.rms_error / reduced.rms_error),
        Goal("AC error, none / constant (must miss 5)", "< 5", ac_none / constant.ac_rms_error),
        Goal(
            "AC error, generalised / learned directly",
            "<= 1.5",
            generalized.ac_rms_error / direct.ac_rms_error,
        ),
        Goal(
            "AC error, generalised / nearest entry",
            "<= 0.3",
            generalized.ac_rms_error / nearest.ac_rms_error,
        ),
        Goal("RMS error in mm, perfect model", "< 0.02", 1e3 * perfect.rms_error),
    ]
