"""Tables of why a tick had no solution, or what its limits cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.markup import escape

from tsd_clients.console.table import Column, console, print_table

# [m/s^2, rad/s^2] below which a cost is not worth a line: a thousandth of what a
# disturbance of a few millimetres is answered with
LEAST_COST = 1e-4


def print_explanation(title: str, found: Mapping[str, Any]) -> None:
    """Print what ``Explanation.plain`` says.

    Args:
        title: Which tick of which log.
    """
    if found["conflict"]:
        _print_conflict(f"{title}: limits that cannot hold together", found["conflict"])
    else:
        _print_costs(title, found["limits"], found["otherwise"])
    if found["dependent"]:
        _say(f"{found['dependent']} of the contacts' rows follow from others and are not held")


def _print_conflict(title: str, rows: Sequence[Mapping[str, Any]]) -> None:
    columns = [
        Column("row", [escape(row["name"]) for row in rows], is_text=True),
        Column("of", [escape(row["where"]) for row in rows], rank=3, is_text=True),
        Column("limit", [escape(row["what"]) for row in rows], rank=2, is_text=True),
        Column("side", [row["side"] for row in rows], rank=1, is_text=True),
        Column("bound", [f"{row['bound']:.4g}" for row in rows]),
        Column("violation", [f"{row['violation']:.4g}" for row in rows]),
        Column("alone", [f"{row['alone']:.4g}" for row in rows]),
        Column("", [row["unit"] for row in rows], is_text=True),
    ]
    print_table(title, columns)
    _say(
        "Without any one of them the others can hold. violation: if all give way, alone: if "
        "this one does alone."
    )


def _print_costs(
    title: str, limits: Sequence[Mapping[str, Any]], otherwise: Mapping[str, float]
) -> None:
    lines: list[tuple[str, str, str, float]] = []
    for limit in limits:
        bound = f"{limit['bound']:.4g} {limit['unit']}"
        lines += [
            (limit["name"], bound, axis, lost)
            for axis, lost in limit["tasks"].items()
            if abs(lost) >= LEAST_COST
        ]
    lines += [
        ("other tasks, posture", "", axis, lost)
        for axis, lost in otherwise.items()
        if abs(lost) >= LEAST_COST
    ]
    names, bounds, axes, lost = zip(*lines, strict=True) if lines else ((), (), (), ())
    columns = [
        Column("active limit", [escape(name) for name in names], is_text=True),
        Column("bound", bounds, rank=1),
        Column("costs axis", [escape(axis) for axis in axes], is_text=True),
        Column("m/s², rad/s²", [f"{value:+.4f}" for value in lost]),
    ]
    print_table(f"{title}: acceleration that the tasks miss", columns)
    if not limits:
        _say("No limit is active.")
    elif quiet := sum(
        all(abs(lost) < LEAST_COST for lost in limit["tasks"].values()) for limit in limits
    ):
        _say(f"{quiet} more active limits cost no task anything.")


def _say(text: str) -> None:
    console.print(text, highlight=False, markup=False)
