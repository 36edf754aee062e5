"""Tables of runs and of what was to be reached."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rich.markup import escape

from tsd_clients.console.table import Column, console, print_table


def print_runs(title: str, summaries: Sequence[Mapping[str, Any]]) -> None:
    """Print runs, one axis of one run per row, and when and after what a robot fell.

    Without any measured lap there is no table.

    Args:
        title: Above the table.
        summaries: From ``Run.summary``, each with a 'label'.
    """
    rows = [
        (summary if index == 0 else None, axis, error)
        for summary in summaries
        for index, (axis, error) in enumerate(summary["errors"].items())
    ]
    units = {f"m{error['unit']}": None for _, _, error in rows} or {"mm": None}
    unit, rate = ", ".join(units), ", ".join(f"{each[1:]}/s²" for each in units)

    def of_run(show: Callable[[Mapping[str, Any]], str]) -> list[str]:
        return ["" if summary is None else show(summary) for summary, _, _ in rows]

    def lengths(name: str) -> list[str]:
        return [number_text(error.get(name), 1e3, 4) for _, _, error in rows]

    feedback = [number_text(error.get("mean_abs_feedback"), 1.0, 5) for _, _, error in rows]
    several = any(len(summary["errors"]) > 1 for summary in summaries)
    columns = [
        Column("run", of_run(lambda run: escape(run["label"]) + _remarks(run)), is_text=True),
        Column("axis", [escape(axis) for _, axis, _ in rows], is_text=True),
        Column(f"RMS\n{unit}", lengths("rms")),
        Column(f"peak\n{unit}", lengths("peak"), rank=5),
        Column(f"AC RMS\n{unit}", lengths("ac_rms"), rank=1),
        Column(f"true RMS\n{unit}", lengths("true_rms"), rank=2),
        Column(f"|fb|\n{rate}", feedback, rank=3),  # mean absolute feedback
        Column("laps", of_run(lambda run: f"{run['laps_measured']}/{run['laps_run']}"), rank=4),
        Column("p50\nµs", of_run(lambda run: number_text(run["tick_us"]["p50"], 1.0, 0)), rank=6),
        Column("p99\nµs", of_run(lambda run: number_text(run["tick_us"]["p99"], 1.0, 0)), rank=7),
    ]
    if several:  # what the iterations are ranked by: of one axis it is P times the RMS
        ranks = of_run(lambda run: number_text(run["rank"], 1.0, 5))
        columns.append(Column("rank\nm/s²", ranks, rank=4))
    fallen = [summary for summary in summaries if summary["fell"]]
    if any(summary["laps_measured"] for summary in summaries) or not fallen:
        print_table(title, columns)
    for summary in fallen:
        console.print(f"{summary['label']}: {_fall(summary)}", markup=False, highlight=False)


def _fall(summary: Mapping[str, Any]) -> str:
    parts = [f"fell at t = {summary['fell_at']:.2f} s"]
    if not summary["laps_measured"]:
        parts.append("before a lap could be measured")
    parts += [f"{count} {status} ticks" for status, count in summary["failures"].items()]
    parts += [f"{count} periods missed, {why}" for why, count in summary["missed"].items()]
    if not summary["failures"] and not summary["missed"]:
        parts.append("every tick was solved")
    return ", ".join(parts)


def print_goals(goals: Sequence[Mapping[str, Any]]) -> None:
    """Print what was to be reached and what was.

    Args:
        goals: With 'id', 'goal', 'measured' and 'met'.
    """
    measured = [goal["measured"] for goal in goals]
    columns = [
        Column("comparison", [escape(goal["id"]) for goal in goals], is_text=True),
        Column("goal", [escape(goal["goal"]) for goal in goals]),
        Column("measured", ["-" if value is None else f"{value:.4g}" for value in measured]),
        Column("", [_verdict(goal) for goal in goals], is_text=True),
    ]
    print_table("goals", columns)


def print_accuracy(file: str, accuracy: Mapping[str, Any]) -> None:
    """Print how good a corrected centre of mass is.

    Args:
        file: Where it was written.
        accuracy: From ``Accuracy.plain``.
    """
    rows = [
        (
            "centre of pressure, measured - expected",
            accuracy["cop_residual_before"],
            accuracy["cop_residual_after"],
        )
    ]
    for index, axis in enumerate("xyz"):
        before, after = (accuracy[f"error_{when}"][index] for when in ("before", "after"))
        rows.append((f"true error of the centre of mass, {axis}", before, after))
    before, after = (accuracy[f"deviation_{when}"][2] for when in ("before", "after"))
    rows.append(("standard deviation of its height at home", before, after))
    names, befores, afters = zip(*rows, strict=True)
    columns = [
        Column("RMS", names, is_text=True),
        Column("model\nmm", [number_text(value, 1e3, 3) for value in befores]),
        Column("corrected\nmm", [number_text(value, 1e3, 3) for value in afters]),
    ]
    print_table(f"centre of mass from {accuracy['poses']} poses, in {file}", columns)


def number_text(value: float | None, scale: float, digits: int) -> str:
    """Write a number for a cell; '-' where there is none.

    Args:
        scale: Factor on it, for another unit.
        digits: After the decimal point.
    """
    return "-" if value is None else f"{scale * value:.{digits}f}"


def _verdict(goal: Mapping[str, Any]) -> str:
    if goal["measured"] is None:
        return "not covered"
    return "[green]met[/green]" if goal["met"] else "[red]missed[/red]"


def _remarks(summary: Mapping[str, Any]) -> str:
    remarks = []
    if summary["fell"]:
        remarks.append("fell")
    elif summary["aborted"]:
        remarks.append("aborted")
    elif not summary["steady"]:
        remarks.append("never steady")
    remarks += [f"{count} ticks {status}" for status, count in summary["failures"].items()]
    at_limits = summary.get("at_limits", {})
    remarks += [f"{escape(joint)} at its limit in {n} ticks" for joint, n in at_limits.items()]
    remarks += [f"{count} periods missed, {why}" for why, count in summary["missed"].items()]
    return f" [red]({', '.join(remarks)})[/red]" if remarks else ""
