"""Tables of what the learner knows and of how it came to know it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.markup import escape

from tsd_clients.console.run_tables import number_text
from tsd_clients.console.table import Column, console, print_table

if TYPE_CHECKING:
    from tsd_casadi.learning.contraction import Contraction
    from tsd_casadi.motions.declaration import Declaration
    from tsd_casadi.wire.axis import AxisErrorMessage
    from tsd_casadi.wire.context import ContextMessage
    from tsd_casadi.wire.learner import DatabaseReply, EntryMessage


def print_entries(reply: DatabaseReply) -> None:
    """Print the database's entries, one axis of an entry per row.

    Those of one context can be compared and generalised together.
    """
    rows = [
        (entry if index == 0 else None, entry, axis)
        for entry in reply.entries
        for index, axis in enumerate(entry.axes)
    ]

    def of_entry(show: Callable[[EntryMessage], str]) -> list[str]:
        return ["" if entry is None else show(entry) for entry, _, _ in rows]

    errors = [_served(entry, axis.name) for _, entry, axis in rows]
    units = ", ".join(dict.fromkeys(f"m{axis.unit}" for _, _, axis in rows)) or "mm"
    untested = ["untested" if each is None else number_text(each.rms, 1e3, 4) for each in errors]
    # a client of somebody's own need not measure it
    without_mean = [
        "" if each is None or each.ac_rms is None else number_text(each.ac_rms, 1e3, 4)
        for each in errors
    ]
    true = [
        "" if each is None or each.true_rms is None else number_text(each.true_rms, 1e3, 4)
        for each in errors
    ]
    scatter = [
        "" if each is None or each.scatter is None else number_text(each.scatter, 1.0, 4)
        for each in errors
    ]
    of_scatter = ", ".join(dict.fromkeys(f"{axis.unit}/s²" for _, _, axis in rows)) or "m/s²"
    corrections = of_entry(lambda entry: escape(entry.context.correction[:6]) or "-")
    values = [{} if entry is None else entry.parameters for entry, _, _ in rows]
    columns = [
        Column("entry", of_entry(lambda entry: str(entry.entry))),
        Column("robot", of_entry(lambda entry: escape(entry.robot)), rank=3, is_text=True),
        Column("motion", of_entry(lambda entry: escape(entry.motion)), rank=2, is_text=True),
        *_parameter_columns(
            [{name: (each.value, each.unit) for name, each in row.items()} for row in values]
        ),
        Column("axis", [escape(axis.name) for _, _, axis in rows], is_text=True),
        Column("served", of_entry(lambda entry: f"{entry.served}/{len(entry.iterations) - 1}")),
        Column(f"its RMS\n{units}", untested),
        Column(f"its AC RMS\n{units}", without_mean, rank=4),
        *_if_any(Column(f"true RMS\n{units}", true, rank=3), true),
        *_if_any(Column(f"repeats to\n{of_scatter}", scatter, rank=5), scatter),
        Column("context", of_entry(lambda entry: describe_body(entry.context)), 1, True),
        *_if_any(
            Column("correction", corrections, 2, True),
            [entry.context.correction for entry in reply.entries],
        ),
        Column("epoch", of_entry(lambda entry: str(_epoch(entry))), rank=5),
        Column("updated", of_entry(lambda entry: entry.updated[:10]), rank=6, is_text=True),
    ]
    print_table(f"database {reply.database}", columns)
    contexts = {tuple(entry.context.model_dump().values()) for entry in reply.entries}
    if len(contexts) > 1:
        console.print(
            f"{len(reply.entries)} entries of {len(contexts)} contexts: those of one context "
            "answer together, see docs/learning.md",
            highlight=False,
        )
    if reply.more:
        console.print(
            f"{reply.more} more that were recorded before: --limit shows more of them, --motion "
            "and --robot less of others, --json all",
            highlight=False,
        )
    for each in reply.damaged:
        console.print(f"entry {each.entry} cannot be read: {escape(each.reason)}", style="red")


def describe_body(context: ContextMessage) -> str:
    """Shorten body and formulation to what tells them from others, 'unknown' if they are."""
    parts = (context.body, context.formulation)
    return " ".join(escape(part[:6]) for part in parts if part) or "unknown"


def describe_context(context: ContextMessage) -> str:
    """Shorten a context to what tells it from others: 'a1b2c3 d4e5f6', 'unknown'."""
    parts = (context.body, context.formulation, context.correction)
    return " ".join(escape(part[:6]) for part in parts if part) or "unknown"


def _if_any(column: Column, known: Sequence[str]) -> list[Column]:
    """Leave a column out in which nothing would be said."""
    return [column] if any(known) else []


def _epoch(entry: EntryMessage) -> int:
    return next((each.epoch for each in entry.iterations if each.number == entry.served), 0)


def _served(entry: EntryMessage, axis: str) -> AxisErrorMessage | None:
    errors = next((each.errors for each in entry.iterations if each.number == entry.served), None)
    return None if errors is None else errors.get(axis)


def print_places(declaration: Declaration, places: Sequence[Mapping[str, Any]]) -> None:
    """Print where learning went by itself, one axis of a place per row.

    Args:
        declaration: What is said of the motion.
        places: With 'parameters', 'standard_deviation' that was predicted
            before, and 'errors' by axis of the runs there.
    """
    rows = [
        (number if index == 0 else None, place, axis)
        for number, place in enumerate(places, start=1)
        for index, axis in enumerate(next(iter(place["errors"]), {"": None}))
    ]

    def errors(index: int) -> list[str]:
        return [
            number_text(place["errors"][index][axis]["rms"] if place["errors"] else None, 1e3, 4)
            for _, place, axis in rows
        ]

    deviations = [
        "" if number is None else number_text(place["standard_deviation"], 1.0, 4)
        for number, place, _ in rows
    ]
    units = (each[axis]["unit"] for _, place, axis in rows for each in place["errors"][:1])
    unit = ", ".join(dict.fromkeys(f"m{each}" for each in units)) or "mm"
    columns = [
        Column("place", ["" if number is None else str(number) for number, _, _ in rows]),
        *_parameter_columns(
            [
                {
                    name: (value, declaration.unit_of(name))
                    for name, value in place["parameters"].items()
                    if number is not None
                }
                for number, place, _ in rows
            ]
        ),
        Column("axis", [axis or "-" for _, _, axis in rows], is_text=True),
        Column("predicted std\nm/s²", deviations, rank=2),
        Column(f"first RMS\n{unit}", errors(0), rank=1),
        Column(f"last RMS\n{unit}", errors(-1)),
    ]
    print_table(f"learned {declaration.motion}, each time where it was most uncertain", columns)


def print_contractions(
    declaration: Declaration, parameters: Mapping[str, float], contractions: Sequence[Contraction]
) -> None:
    """Print what an iteration leaves of an error, one harmonic per row.

    Args:
        declaration: What is said of the motion.
        parameters: Its parameters, SI units.
        contractions: By learned axis.
    """
    for item in contractions:
        title = (
            f"what an iteration leaves of the error along {item.axis}, {declaration.motion} "
            f"{describe_values(declaration, parameters)}\n"
            f"loop gain {item.gain:.2f} ± {item.gain_deviation:.2f}, "
            f"delay {1e3 * item.delay:.1f} ± {1e3 * item.delay_deviation:.1f} ms; "
            f"lead {1e3 * item.lead:.1f} ms, bandwidth {item.bandwidth:.3g} Hz"
        )
        shares = {
            "plain sum": item.plain,
            # no bound: it is exceeded where the loop is not linear
            "predicted,\nif linear": item.predicted,
            "observed": item.observed,
        }
        columns = [
            Column("harmonic", [str(number) for number in range(len(item.frequency))]),
            Column("Hz", [f"{frequency:.3g}" for frequency in item.frequency]),
        ]
        columns += [
            Column(heading, [number_text(value, 1.0, 2) for value in values])
            for heading, values in shares.items()
        ]
        print_table(title, columns)


def describe_parameters(entry: EntryMessage) -> str:
    """Name the parameters of an entry with units."""
    return _described({name: (each.value, each.unit) for name, each in entry.parameters.items()})


def describe_values(declaration: Declaration, parameters: Mapping[str, float]) -> str:
    """Name parameters with units: 'amplitude 0.03 m, frequency 0.25 Hz, height 0 m'.

    Args:
        declaration: What is said of the motion.
        parameters: Values by name, SI units.
    """
    return _described(
        {name: (value, declaration.unit_of(name)) for name, value in parameters.items()}
    )


def _described(values: Mapping[str, tuple[float, str]]) -> str:
    return ", ".join(
        f"{name} {value:g} {_unit(unit)}".rstrip() for name, (value, unit) in values.items()
    )


def _parameter_columns(rows: Sequence[Mapping[str, tuple[float, str]]]) -> list[Column]:
    """One column for each parameter that some row has, its unit in the heading."""
    headings = {(name, unit): None for row in rows for name, (_, unit) in row.items()}
    return [
        Column(
            f"{name}\n{_unit(unit)}".rstrip(),
            [f"{row[name][0]:g}" if name in row and row[name][1] == unit else "" for row in rows],
        )
        for name, unit in headings
    ]


def _unit(unit: str) -> str:
    """Write a unit for people: nothing of a plain number."""
    return "" if unit == "1" else unit
