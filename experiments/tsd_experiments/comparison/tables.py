"""What the report says of the methods in one scenario."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tsd_experiments.comparison.compare import SEEN
from tsd_experiments.comparison.generalized_methods import GENERALIZED
from tsd_experiments.harness.job import Result
from tsd_experiments.harness.section import Table, millimeters
from tsd_experiments.report.drawing import draw_lines

RECOVERED = 1e-3  # m, as in the comparison of stiffness
# what is compared: an identified controller computes the centre of mass with its
# own inertias, and only the simulated robot's error means the same for all
MEASURE = "true_ac_rms_error_m"
TRANSFERS = ("none", "amplitude", "frequency", "posture")
HEADINGS = ("as learned", "at 5 cm", "at the other frequency", "5.5 cm higher")


def methods_table(
    scenario: str,
    results: Mapping[str, Result],
    generalized: Mapping[str, Result],
    transfers: Sequence[str],
) -> Table:
    """Write the errors of all methods, with what a push does to them.

    Args:
        results: What ``compare`` left behind, by method.
        generalized: What ``compare_generalized`` left behind, by method.
        transfers: Those of ``TRANSFERS`` that were run.
    """
    rows = []
    for method, result in results.items():
        own, push = result.row("none"), result.row("push")
        rows.append(
            [
                method,
                str(own["numbers_learned"]),
                millimeters(own["rms_error_m"]),
                millimeters(own["true_rms_error_m"]),
                *(_ac(result, transfer) for transfer in transfers),
                _generalized_cell(generalized.get(method)),
                millimeters(push["deflection_m"], 2),
                _recovery(result),
            ]
        )
    return Table(
        f"{scenario}: errors of the centre of mass [mm]; where nothing else is said the true "
        "error without its mean (AC); * where the run never became steady; recovered: below "
        f"{1e3 * RECOVERED:g} mm for good",
        [
            "method",
            "numbers learned",
            "RMS as the controller sees it",
            "true RMS",
            *HEADINGS[: len(transfers)],
            "generalised to 5 cm",
            "deflection by 10 N s",
            "recovered after [s]",
        ],
        rows,
    )


def torque_or_acceleration_sentence(
    scenario: str, results: Mapping[str, Result], generalized: Mapping[str, Result]
) -> str:
    """Tell whether joint torques generalise worse, as the paper expects.

    Args:
        results: What ``compare`` left behind, by method.
        generalized: What ``compare_generalized`` left behind, by method.
    """
    pairs = {
        heading: [results[method].row(label)[MEASURE] for method in GENERALIZED]
        for label, heading in zip(TRANSFERS, HEADINGS, strict=True)
    }
    pairs["generalised to 5 cm"] = [
        generalized[method].row("generalised")[MEASURE] for method in GENERALIZED
    ]
    pairs = {heading: pair for heading, pair in pairs.items() if None not in pair}
    told = ", ".join(
        f"{heading} {torque / acceleration:.2g}"
        for heading, (acceleration, torque) in pairs.items()
    )
    worse = sum(torque > 1.1 * acceleration for acceleration, torque in pairs.values())
    return (
        f"{scenario}, error with learned joint torques by error with task accelerations of the "
        f"same plain sum: {told}. The paper's expectation that joint torques generalise "
        f"poorly shows in {worse} of {len(pairs)}."
    )


def winners_sentence(scenario: str, results: Mapping[str, Result]) -> str:
    """Tell which method is the most accurate in each transfer, and which the softest.

    Args:
        results: What ``compare`` left behind, by method.
    """

    def best(label: str) -> str:
        measured = {
            method: result.row(label)[MEASURE]
            for method, result in results.items()
            if any(row["label"] == label for row in result.rows)
            and result.row(label)[MEASURE] is not None
        }
        winner = min(measured, key=lambda method: measured[method])
        return f"{winner} ({1e3 * measured[winner]:.3f} mm)"

    labels = [row["label"] for row in next(iter(results.values())).rows if row["label"] != "push"]
    parts = [f"{HEADINGS[TRANSFERS.index(label)]} {best(label)}" for label in labels]
    softest = max(results, key=lambda method: results[method].row("push")["deflection_m"])
    deflection = results[softest].row("push")["deflection_m"]
    return (
        f"{scenario}, smallest true AC error: {', '.join(parts)}. Gives way most to a push: "
        f"{softest} ({1e3 * deflection:.1f} mm)."
    )


def _recovery(result: Result) -> str:
    """Tell when the deflection stays small for good."""
    if result.row("push").get("fell"):
        return "fell"
    time, deflection = result.arrays["push/time"], result.arrays["push/deflection"]
    away = np.flatnonzero(np.abs(deflection) > RECOVERED)
    if not away.size:
        return "0.00"
    return f"{time[away[-1]]:.2f}" if away[-1] < len(time) - 1 else f"not within {SEEN:g}"


def _ac(result: Result, transfer: str) -> str:
    row: dict[str, Any] = result.row(transfer)
    if row["fell"]:
        return "fell"
    return millimeters(row[MEASURE]) + ("" if row["steady"] else " *")


def _generalized_cell(result: Result | None) -> str:
    return "–" if result is None else millimeters(result.row("generalised")[MEASURE])


def draw_pushes(results: Mapping[str, Result]) -> Any:
    """Draw the deflection by the push, one line per method.

    Args:
        results: What ``compare`` left behind, by method.
    """
    lines = [
        (method, result.arrays["push/time"][::20], 1e3 * result.arrays["push/deflection"][::20])
        for method, result in results.items()
    ]
    return draw_lines(lines, "time after the push [s]", "deflection [mm]", logy=False)
