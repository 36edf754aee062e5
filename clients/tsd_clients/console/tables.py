"""Tables for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.motions.parameter import unit_of
from tsd_casadi.wire.learner import DatabaseReply, EntryMessage

# tables need this many columns; pipes and narrow terminals get them as well
WIDTH = 130
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
        if goal["measured"] is None:
            table.add_row(escape(goal["id"]), goal["goal"], "-", "not covered")
            continue
        verdict = "[green]met[/green]" if goal["met"] else "[red]missed[/red]"
        table.add_row(escape(goal["id"]), goal["goal"], f"{goal['measured']:.4g}", verdict)
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
        collapse_padding=True,
        pad_edge=False,
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
            _number(errors["rms_error_m"], 1e3, 4) if errors else "untested",
            # a client of somebody's own need not measure it
            _number(errors.get("ac_rms_error_m"), 1e3, 4) if errors else "",
            entry.updated[:10],
        )
    console.print(table)


def print_places(task: str, places: Sequence[dict[str, Any]]) -> None:
    """Print where learning went by itself, one place per row.

    Args:
        task: Name of the motion.
        places: With 'parameters', 'standard_deviation' that was predicted
            before, and 'rms_errors_m' of the runs there.
    """
    table = Table(
        title=f"learned {task}, each time where it was most uncertain",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        padding=(0, 1),
    )
    table.add_column("place")
    table.add_column("parameters", no_wrap=True)
    for heading in ("predicted std\nm/s²", "first RMS\nmm", "last RMS\nmm"):
        table.add_column(heading, justify="right", no_wrap=True)
    for number, place in enumerate(places, start=1):
        errors = place["rms_errors_m"] or [None]
        table.add_row(
            str(number),
            describe_values(task, place["parameters"]),
            _number(place["standard_deviation"], 1.0, 4),
            _number(errors[0], 1e3, 4),
            _number(errors[-1], 1e3, 4),
        )
    console.print(table)


def print_accuracy(file: str, accuracy: Mapping[str, Any]) -> None:
    """Print how good a corrected centre of mass is.

    Args:
        file: Where it was written.
        accuracy: From ``Accuracy.plain``.
    """
    table = Table(
        title=f"centre of mass from {accuracy['poses']} poses, in {file}",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        padding=(0, 1),
    )
    table.add_column("RMS")
    for heading in ("model\nmm", "corrected\nmm"):
        table.add_column(heading, justify="right", no_wrap=True)

    def add(name: str, before: float, after: float) -> None:
        table.add_row(name, _number(before, 1e3, 3), _number(after, 1e3, 3))

    add(
        "centre of pressure, measured - expected",
        accuracy["cop_residual_before"],
        accuracy["cop_residual_after"],
    )
    for index, axis in enumerate("xyz"):
        before, after = (accuracy[f"error_{when}"][index] for when in ("before", "after"))
        add(f"true error of the centre of mass, {axis}", before, after)
    before, after = (accuracy[f"deviation_{when}"][2] for when in ("before", "after"))
    add("standard deviation of its height at home", before, after)
    console.print(table)


def print_contractions(
    task: str, parameters: Mapping[str, float], contractions: Sequence[Contraction]
) -> None:
    """Print what an iteration leaves of an error, one harmonic per row.

    Args:
        task: Name of the motion.
        parameters: Its parameters, SI units.
        contractions: By learned axis.
    """
    for item in contractions:
        console.print(
            f"[italic]what an iteration leaves of the error along {item.axis}, {task} "
            f"{describe_values(task, parameters)}\n"
            f"loop gain {item.gain:.2f} ± {item.gain_deviation:.2f}, "
            f"delay {1e3 * item.delay:.1f} ± {1e3 * item.delay_deviation:.1f} ms; "
            f"lead {1e3 * item.lead:.1f} ms, bandwidth {item.bandwidth:.3g} Hz[/italic]",
            highlight=False,
        )
        table = Table(box=box.SIMPLE_HEAD, padding=(0, 1))
        for heading in ("harmonic", "Hz", "plain sum", "predicted,\nat most", "observed"):
            table.add_column(heading, justify="right", no_wrap=True)
        shares = zip(item.frequency, item.plain, item.predicted, item.observed, strict=True)
        for harmonic, (frequency, *row) in enumerate(shares):
            table.add_row(
                str(harmonic), f"{frequency:.3g}", *(_number(value, 1.0, 2) for value in row)
            )
        console.print(table)


def describe_parameters(entry: EntryMessage) -> str:
    """Task parameters of an entry with units.

    Args:
        entry: The entry.
    """
    return describe_values(entry.task, {name: q.value for name, q in entry.parameters.items()})


def describe_values(task: str, parameters: Mapping[str, float]) -> str:
    """Task parameters with units: 'amplitude 0.03 m, frequency 0.25 Hz, height 0 m'.

    Args:
        task: Name of the motion.
        parameters: Values by name, SI units.
    """
    return ", ".join(
        f"{name} {value:g} {unit_of(task, name)}".rstrip() for name, value in parameters.items()
    )
