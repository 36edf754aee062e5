"""The rows of the table: which runs they need, and what their goals are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tsd_casadi.learning.rules.rule import RuleName
from tsd_experiments.beyond.outside_the_lab.robots import MODEL_ERROR
from tsd_experiments.beyond.outside_the_lab.rows import (
    AFTER,
    ITERATIONS,
    NOISE,
    learn_quietly,
    learn_through_change,
    learn_under_noise,
    learn_until_return,
)
from tsd_experiments.harness.section import Goal

ROWS = ("noise", "quiet", "change", "small", "return")
# by seed in turn: model error of the robot afterwards, and load on it [kg]
CHANGES = ((0.03, 0.0), (MODEL_ERROR, 3.0), (MODEL_ERROR, -3.0))
SMALLEST = 0.3  # kg
# an error this close to the least one that the plain sum reaches counts as reached
REACHED = 1.1

Results = dict[str, list[dict[str, Any]]]


@dataclass(frozen=True)
class LabJob:
    """What is run with one seed.

    Attributes:
        row: Of ``ROWS``, 'change/plain' for the plain sum beside 'change'.
        seed: Of posture, noise and the repetition of a change.
        function: At the top of a module, so that worker processes find it.
        arguments: Plain data.
    """

    row: str
    seed: int
    function: Callable[..., dict[str, Any]]
    arguments: tuple[Any, ...]


def jobs_of(
    rows: Sequence[str], robot: str, rule: RuleName, seeds: Sequence[int], iterations: int
) -> list[LabJob]:
    """List what some rows need.

    Args:
        robot: Its name, or the path of its file.
        iterations: Of the row 'quiet'.
    """
    jobs = []
    for seed in seeds:
        # at a random repetition, at the earliest when something was learned
        at = int(np.random.default_rng(seed).integers(1, 9))
        change = CHANGES[seed % len(CHANGES)]
        known = {
            "noise": [LabJob("noise", seed, learn_under_noise, (robot, rule, seed))],
            "quiet": [LabJob("quiet", seed, learn_quietly, (robot, rule, seed, iterations))],
            "change": [
                LabJob("change", seed, learn_through_change, (robot, rule, seed, at, *change)),
                LabJob(
                    "change/plain",
                    seed,
                    learn_through_change,
                    (robot, "plain", seed, at, *change),
                ),
            ],
            # converged: what comes of the first change is large against it
            "small": [
                LabJob(
                    "small",
                    seed,
                    learn_through_change,
                    (robot, rule, seed, ITERATIONS, MODEL_ERROR, (-1) ** seed * SMALLEST, NOISE),
                )
            ],
            "return": [
                LabJob(
                    "return",
                    seed,
                    learn_until_return,
                    (robot, rule, seed, ITERATIONS + 1, (-1) ** seed * CHANGES[1][1]),
                )
            ],
        }
        jobs += [job for row in rows for job in known[row]]
    return jobs


def goals_of(results: Results) -> list[Goal]:
    """Compare what was measured with the goals; what was not run is not covered."""
    return [
        *_noise_goals(results.get("noise", [])),
        *_quiet_goals(results.get("quiet", [])),
        *_change_goals(results.get("change", []), results.get("change/plain", [])),
        *_small_goals(results),
        *_return_goals(results.get("return", [])),
    ]


def _noise_goals(rows: list[dict[str, Any]]) -> list[Goal]:
    learned = [row for row in rows if row["refused"] is None]
    ratios = [row["after"] / row["floor"] for row in learned]
    replays = [row["replay"] for row in learned]
    refused = float(len(rows) - len(learned)) if rows else None
    return [
        Goal(f"{NOISE:g} N m of noise: refusals", "<= 0", refused),
        Goal("noise: RMS after 5 / floor, median", "<= 1.1", _median(ratios)),
        Goal("noise: RMS after 5 / floor, worst", "<= 1.3", _worst(ratios)),
        Goal("noise: replayed without [mm], median", "<= 0.08", _median(replays)),
        Goal("noise: replayed without [mm], worst", "<= 0.12", _worst(replays)),
    ]


def _quiet_goals(rows: list[dict[str, Any]]) -> list[Goal]:
    after = [row["errors"][ITERATIONS] for row in rows if len(row["errors"]) > ITERATIONS]
    later = [error for row in rows for error in row["errors"][7:]]
    return [
        Goal("no extra noise: RMS after 5 [mm], worst", "<= 0.06", _worst(after)),
        Goal("no extra noise: worst RMS of 7 on [mm]", "<= 0.04", _worst(later)),
    ]


def _change_goals(rows: list[dict[str, Any]], plain: list[dict[str, Any]]) -> list[Goal]:
    sums = {row["seed"]: row["errors"] for row in plain}
    more = [
        float(repetitions_more(row["errors"], sums[row["seed"]]))
        for row in rows
        if row["seed"] in sums
    ]
    second = [row["errors"][2] for row in rows]
    return [
        Goal("change: repetitions more than the plain sum, worst", "<= 0", _worst(more)),
        Goal("change: RMS after 2 repetitions [mm], median", "<= 0.06", _median(second)),
        Goal("change: RMS after 2 repetitions [mm], worst", "<= 0.06", _worst(second)),
    ]


def _small_goals(results: Results) -> list[Goal]:
    small = results.get("small", [])
    missed = [float(not row["at_once"]) for row in small]
    every = [row for row_name in ROWS for row in results.get(row_name, []) if "alarms" in row]
    repetitions = sum(row["repetitions"] for row in every)
    alarms = sum(row["alarms"] for row in every)
    return [
        Goal(f"+-{SMALLEST:g} kg in noise: not noticed at once", "<= 0", _sum(missed)),
        Goal(
            f"false alarms in {repetitions} repetitions [%]",
            "< 1",
            100 * alarms / repetitions if repetitions else None,
        ),
    ]


def _return_goals(rows: list[dict[str, Any]]) -> list[Goal]:
    missed = [float(not row["again"]) for row in rows]
    first = [row["errors"][1] for row in rows]
    return [
        Goal("a load goes again: what was learned before not taken", "<= 0", _sum(missed)),
        Goal("a load goes again: RMS of the next repetition [mm], worst", "<= 0.06", _worst(first)),
    ]


def repetitions_more(errors: Sequence[float], sums: Sequence[float]) -> int:
    """Count the repetitions after a change that are needed beyond those of the plain sum.

    Args:
        errors: RMS of each repetition from the change on.
        sums: Those of the plain sum.

    Returns:
        Until ``REACHED`` times the least error of the plain sum, at most one more
        than there were.
    """
    wanted = REACHED * min(sums)

    def needed(found: Sequence[float]) -> int:
        return next((count for count, error in enumerate(found) if error <= wanted), AFTER + 1)

    return needed(errors) - needed(sums)


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if values else None


def _worst(values: Sequence[float]) -> float | None:
    return max(values) if values else None


def _sum(values: Sequence[float]) -> float | None:
    return sum(values) if values else None
