"""What the demonstration has to show."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot_file_goals import DemoGoalsFile
from tsd_experiments.demo.plan import REUSED, Plan, label_of
from tsd_experiments.harness.section import Goal


def goals_of(runs: Mapping[str, Run], plan: Plan, wanted: DemoGoalsFile) -> list[Goal]:
    """Measure what the method promises, as ratios of two runs of this demonstration.

    Args:
        wanted: What the robot's file asks for.
    """
    none, constant, perfect, first, second, reduced = (
        _error(runs[label_of(plan.amplitude, what)])
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
        _error(runs[label_of(plan.queried, what)])
        for what in ("generalised", "learned, iteration 2", REUSED)
    )
    return [
        Goal(
            "RMS error, none / one iteration", f">= {wanted.rms_after_one:g}", none.rms / first.rms
        ),
        Goal("AC error, none / one iteration", f">= {wanted.ac_after_one:g}", none.ac / first.ac),
        Goal("AC error, none / two iterations", f">= {wanted.ac_after_two:g}", none.ac / second.ac),
        Goal(
            "mean |feedback|, none / one iteration",
            f">= {wanted.feedback_after_one:g}",
            none.feedback / first.feedback,
        ),
        Goal(
            "RMS error, none at P / learned at P/5",
            f">= {wanted.rms_at_a_fifth:g}",
            none.rms / reduced.rms,
        ),
        Goal(
            f"AC error, none / constant (must miss {wanted.ac_constant:g})",
            f"< {wanted.ac_constant:g}",
            none.ac / constant.ac,
        ),
        Goal(
            "AC error, generalised / learned directly",
            f"<= {wanted.ac_generalized:g}",
            generalized.ac / direct.ac,
        ),
        Goal(
            "AC error, generalised / nearest entry",
            f"<= {wanted.ac_by_nearest:g}",
            generalized.ac / nearest.ac,
        ),
        Goal("RMS error in mm, perfect model", f"< {wanted.rms_perfect:g}", 1e3 * perfect.rms),
    ]


class _Error(NamedTuple):
    """Of the axis that is moved."""

    rms: float
    ac: float
    feedback: float


def _error(run: Run) -> _Error:
    error = run.errors[run.axes[0]]
    assert error.ac_rms is not None and error.mean_abs_feedback is not None
    return _Error(error.rms, error.ac_rms, error.mean_abs_feedback)
