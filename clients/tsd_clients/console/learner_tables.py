"""Tables of what the learner knows and of how it came to know it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.markup import escape

from tsd_casadi.motions.parameter import unit_of
from tsd_clients.console.run_tables import number_text
from tsd_clients.console.table import Column, print_table

if TYPE_CHECKING:
    from tsd_casadi.learning.contraction import Contraction
    from tsd_casadi.wire.learner import DatabaseReply, EntryMessage


def print_entries(reply: DatabaseReply) -> None:
    """Print the database's entries, one per row."""
    entries = reply.entries
    served = [dict(entry.iterations).get(entry.served) for entry in entries]
    errors = [number_text(each["rms_error_m"], 1e3, 4) if each else "untested" for each in served]
    # a client of somebody's own need not measure it
    without_mean = [
        number_text(each.get("ac_rms_error_m"), 1e3, 4) if each else "" for each in served
    ]
    columns = [
        Column("entry", [str(entry.entry) for entry in entries]),
        Column("robot", [escape(entry.robot) for entry in entries], rank=2, is_text=True),
        Column("motion", [escape(entry.task) for entry in entries], rank=1, is_text=True),
        *_parameter_columns([(entry.task, _values(entry)) for entry in entries]),
        Column("served", [f"{entry.served}/{len(entry.iterations) - 1}" for entry in entries]),
        Column("its RMS\nmm", errors),
        Column("its AC RMS\nmm", without_mean, rank=3),
        Column("updated", [entry.updated[:10] for entry in entries], rank=4, is_text=True),
    ]
    print_table(f"database {reply.database}", columns)


def print_places(motion: str, places: Sequence[Mapping[str, Any]]) -> None:
    """Print where learning went by itself, one place per row.

    Args:
        places: With 'parameters', 'standard_deviation' that was predicted
            before, and 'rms_errors_m' of the runs there.
    """
    errors = [place["rms_errors_m"] or [None] for place in places]
    deviations = [number_text(place["standard_deviation"], 1.0, 4) for place in places]
    columns = [
        Column("place", [str(number) for number in range(1, len(places) + 1)]),
        *_parameter_columns([(motion, place["parameters"]) for place in places]),
        Column("predicted std\nm/s²", deviations, rank=2),
        Column("first RMS\nmm", [number_text(each[0], 1e3, 4) for each in errors], rank=1),
        Column("last RMS\nmm", [number_text(each[-1], 1e3, 4) for each in errors]),
    ]
    print_table(f"learned {motion}, each time where it was most uncertain", columns)


def print_contractions(
    motion: str, parameters: Mapping[str, float], contractions: Sequence[Contraction]
) -> None:
    """Print what an iteration leaves of an error, one harmonic per row.

    Args:
        parameters: Its parameters, SI units.
        contractions: By learned axis.
    """
    for item in contractions:
        title = (
            f"what an iteration leaves of the error along {item.axis}, {motion} "
            f"{describe_values(motion, parameters)}\n"
            f"loop gain {item.gain:.2f} ± {item.gain_deviation:.2f}, "
            f"delay {1e3 * item.delay:.1f} ± {1e3 * item.delay_deviation:.1f} ms; "
            f"lead {1e3 * item.lead:.1f} ms, bandwidth {item.bandwidth:.3g} Hz"
        )
        shares = {
            "plain sum": item.plain,
            "predicted,\nat most": item.predicted,
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
    return describe_values(entry.task, _values(entry))


def describe_values(motion: str, parameters: Mapping[str, float]) -> str:
    """Name parameters with units: 'amplitude 0.03 m, frequency 0.25 Hz, height 0 m'.

    Args:
        parameters: Values by name, SI units.
    """
    return ", ".join(
        f"{name} {value:g} {unit_of(motion, name)}".rstrip() for name, value in parameters.items()
    )


def _values(entry: EntryMessage) -> dict[str, float]:
    return {name: quantity.value for name, quantity in entry.parameters.items()}


def _parameter_columns(rows: Sequence[tuple[str, Mapping[str, float]]]) -> list[Column]:
    """One column for each parameter that some row has, its unit in the heading."""
    headings: dict[tuple[str, str], None] = {}
    for motion, values in rows:
        headings |= {(name, unit_of(motion, name)): None for name in values}
    return [
        Column(
            f"{name}\n{unit}".rstrip(),
            [
                f"{values[name]:g}" if name in values and unit_of(motion, name) == unit else ""
                for motion, values in rows
            ],
        )
        for name, unit in headings
    ]
