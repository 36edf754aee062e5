"""Tables for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from tsd_casadi.messages import DatabaseReply, EntryMessage

# tables need this many columns; pipes and narrow terminals get them as well
WIDTH = 120
console = Console()
if console.width < WIDTH:
    console = Console(width=WIDTH)


def print_runs(title: str, summaries: Sequence[dict[str, Any]]) -> None:
    """Print runs, one per row.

    Args:
        title: Heading.
        summaries: From ``Run.summary``, each with a 'label'.
    """
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1))
    table.add_column("run")
    for heading in (
        "RMS\nmm",
        "peak\nmm",
        "AC RMS\nmm",
        "true RMS\nmm",
        "|fb|\nm/s²",  # mean absolute feedback
        "laps",
        "p50\nµs",
        "p99\nµs",
    ):
        table.add_column(heading, justify="right", no_wrap=True)
    for summary in summaries:
        table.add_row(
            summary["label"] + _remarks(summary),
            *[
                _number(summary[name], 1e3, 4)
                for name in ("rms_error_m", "peak_error_m", "ac_rms_error_m", "true_rms_error_m")
            ],
            _number(summary["mean_abs_feedback"], 1.0, 5),
            f"{summary['laps_measured']}/{summary['laps_run']}",
            f"{summary['tick_us']['p50']:.0f}",
            f"{summary['tick_us']['p99']:.0f}",
        )
    console.print(table)


def _number(value: float | None, scale: float, digits: int) -> str:
    return "-" if value is None else f"{scale * value:.{digits}f}"


def _remarks(summary: dict[str, Any]) -> str:
    remarks = []
    if summary["fell"]:
        remarks.append("fell")
    elif not summary["steady"]:
        remarks.append("never steady")
    remarks += [f"{count} ticks {status}" for status, count in summary["failures"].items()]
    return f" [red]({', '.join(remarks)})[/red]" if remarks else ""


def print_goals(goals: Sequence[dict[str, Any]]) -> None:
    """Print what was to be reached and what was.

    Args:
        goals: With 'id', 'goal', 'measured' and 'met'.
    """
    table = Table(title="goals", title_justify="left", box=box.SIMPLE_HEAD)
    table.add_column("comparison")
    table.add_column("goal", justify="right")
    table.add_column("measured", justify="right")
    table.add_column("")
    for goal in goals:
        verdict = "[green]met[/green]" if goal["met"] else "[red]missed[/red]"
        table.add_row(goal["id"], goal["goal"], f"{goal['measured']:.4g}", verdict)
    console.print(table)


def print_entries(reply: DatabaseReply) -> None:
    """Print the database's entries.

    Args:
        reply: The learner's answer.
    """
    table = Table(
        title=f"database {reply.database}",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        padding=(0, 1),
    )
    for heading in ("entry", "robot", "task", "parameters"):
        table.add_column(heading, no_wrap=True)
    for heading in ("served", "its RMS\nmm", "its AC RMS\nmm"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("updated", no_wrap=True)
    for entry in reply.entries:
        errors = dict(entry.iterations).get(entry.served)
        table.add_row(
            str(entry.entry),
            entry.robot,
            entry.task,
            describe_parameters(entry),
            f"{entry.served} of {len(entry.iterations) - 1}",
            f"{1e3 * errors['rms_error_m']:.4f}" if errors else "untested",
            f"{1e3 * errors['ac_rms_error_m']:.4f}" if errors else "",
            entry.updated[:10],
        )
    console.print(table)


def describe_parameters(entry: EntryMessage) -> str:
    """Task parameters with units.

    Args:
        entry: The entry.
    """
    return ", ".join(f"{name} {q.value:g} {q.unit}" for name, q in entry.parameters.items())
