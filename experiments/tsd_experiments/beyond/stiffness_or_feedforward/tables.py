"""Cells of the tables on stiffness: who was pushed, shaken, and who won."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tsd_experiments.beyond.stiffness_or_feedforward.sweep_results import (
    end_of,
    highest_stable,
    is_bounded,
)
from tsd_experiments.harness.case import SOFT
from tsd_experiments.harness.job import Result
from tsd_experiments.harness.section import millimeters

IMPULSE = 10.0  # N s
NOISE = 1.0  # N m
PUSHES = {"down": [0.0, 0.0, -IMPULSE], "sideways": [0.0, IMPULSE, 0.0]}
PUSH_HEAD = (
    "down: peak",
    "recovery",
    "ground [N]",
    "torque [%]",
    "sideways: peak",
    "recovery",
    "torque [%]",
)
NOISE_HEAD = ("noise: added [mm]", "added torque [N m]")
# heading, row, measure
_MEASURES = (
    ("tracking", "undisturbed", "rms_error_m"),
    ("down: peak", "down", "peak_deflection_m"),
    ("recovery", "down", "recovery_s"),
    ("sideways: peak", "sideways", "peak_deflection_m"),
    ("ground force", "down", "peak_ground_force_n"),
    ("torque", "down", "peak_torque_share"),
    ("noise: motion", "noise", "added_rms_m"),
    ("noise: torque", "noise", "added_torque_rms_nm"),
)
VERDICTS = tuple(heading for heading, _, _ in _MEASURES)


def words_for(name: str) -> str:
    """Name a contender for people.

    Args:
        name: 'soft learned', 'stiff none' or 'own learned'.
    """
    return {
        "soft learned": "soft, feedforward",
        "stiff none": "stiff, none",
        "own learned": "robot's own P, feedforward",
    }[name]


def own_stiffness(learned: Result) -> float:
    """Compute P of the robot file from a run at ``SOFT`` of it [1/s^2]."""
    row = learned.rows[0]
    return float(row["gains"]["P"][-1]) / SOFT


def disturbed_cells(result: Result) -> list[str]:
    """Write the RMS error, then what ``PUSH_HEAD`` and ``NOISE_HEAD`` say.

    Args:
        result: Of ``disturb``.
    """
    cells = [f"{1e3 * result.row('undisturbed')['rms_error_m']:.2g}"]
    for push, ground in (("down", True), ("sideways", False)):
        row = result.row(push)
        cells.append("fell" if row["fell"] else millimeters(row["peak_deflection_m"], 2))
        cells.append(_recovery(result, push))
        if ground:
            cells.append(f"{row['peak_ground_force_n']:.0f}")
        cells.append(f"{100 * row['peak_torque_share']:.0f}")
    for row in result.rows:
        if row["label"] == "noise":
            torque = row["added_torque_rms_nm"]
            cells.append(millimeters(row["added_rms_m"]))
            return [*cells, "fell" if torque is None else f"{torque:.2f}"]
    return [*cells, "–", "–"]


def _recovery(result: Result, push: str) -> str:
    row = result.row(push)
    if row["fell"]:
        return "–"
    if row["recovery_s"] is not None:
        return f"{row['recovery_s']:.2f}"
    along = result.arrays[f"{push}/deflection"] @ (np.array(PUSHES[push]) / IMPULSE)
    return f"not: {1e3 * float(along[-1]):.1f} mm left"


def limit_cells(sweeps: Mapping[str, Sequence[dict[str, Any]]], own: float) -> list[list[str]]:
    """Write what ended each sweep, and where.

    Args:
        sweeps: Rows of a sweep by its feedforward.
        own: P of the robot file [1/s^2].
    """
    rows = []
    for feedforward, swept in sweeps.items():
        limit = highest_stable(swept)
        chatter = next(row["chatter"] for row in swept if row["factor"] == limit)
        more = "" if is_bounded(swept) else "above "
        cells = [f"{more}{own * limit:.3g}", f"{100 * chatter:.2g}", end_of(swept)]
        rows.append([feedforward, *cells])
    return rows


def verdicts(results: Mapping[str, Result]) -> list[str]:
    """Tell who wins in each column of ``VERDICTS``; a dash where nobody was measured."""
    soft, stiff = results["soft learned"], results["stiff none"]
    measured = {row["label"] for row in soft.rows}
    return [
        _winner(soft.row(label).get(measure), stiff.row(label).get(measure))
        if label in measured
        else "–"
        for _, label, measure in _MEASURES
    ]


def _winner(soft: float | None, stiff: float | None) -> str:
    """Tell who has less of what nobody wants; nothing measured is a loss."""
    if soft is None or stiff is None:
        return {(True, False): "stiff", (False, True): "soft"}.get(
            (soft is None, stiff is None), "neither"
        )
    if math.isclose(soft, stiff, rel_tol=0.1):
        return "equal"
    return "soft" if soft < stiff else "stiff"
