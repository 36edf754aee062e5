"""A database file of many entries, as if all of them had been learned."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tsd_casadi.database.checksum import with_checksum
from tsd_casadi.database.columns import encode, entry_columns, event_columns, iteration_columns
from tsd_casadi.database.database import Database
from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.axis_error import AxisError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry import Entry
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.recording import Recording
from tsd_casadi.motions.squat import Squat

ROBOT = "hermes_lower"
AXES = ("com.x", "com.y", "com.z")
CONTEXT = Context("00ff", "abcd")
FREQUENCIES = 1_000
P, D = 50.0, 14.0
LEARNED = "2026-01-01T00:00:00+00:00"


def squat(number: int) -> dict[str, float]:
    """Give the parameters of the entry of a number, from 1 on: none are the same."""
    amplitude, frequency = divmod(number, FREQUENCIES)
    return {
        "amplitude": round(0.01 + 1e-4 * amplitude, 6),
        "frequency": round(0.1 + 1e-3 * frequency, 6),
        "height": 0.0,
    }


def recording(parameters: dict[str, float]) -> Recording:
    """Make the recording of a squat along three axes, without feedforward."""
    basis = PeriodicBasis()
    phase = np.linspace(0, 2 * np.pi, 250, endpoint=False)
    scale = parameters["amplitude"] + parameters["frequency"]
    signal = np.tile(scale * np.sin(phase), (len(AXES), 1))
    error = signal / P
    rate = 2 * np.pi * parameters["frequency"] * np.tile(scale * np.cos(phase), (len(AXES), 1)) / P
    gains = {"P": [P] * len(AXES), "D": [D] * len(AXES)}
    return Recording(
        key=EntryKey.of(ROBOT, "squat", Squat.version, AXES, parameters, CONTEXT),
        basis=basis,
        applied=np.zeros((len(AXES), basis.L)),
        laps=[Lap(phase, P * error + D * rate, error, signal)] * 2,
        errors={axis: AxisError(1e-3, ac_rms=1e-4) for axis in AXES},
        circumstances=Circumstances(gains, {"seed": 0}, "benchmark"),
        declaration=Squat.declaration(),
    )


def fill(path: Path, entries: int) -> None:
    """Make a file with entries of numbers from 1 on, each recorded once.

    The rows are those of ``Database.record``, but for parameters and numbers the
    same for all, so that a hundred thousand take half a minute.
    """
    template = recording(squat(1))
    entry = Entry(template.key, template.basis, template.circumstances)
    entry.add(template)
    entry.updated = LEARNED
    with Database(path) as database:
        file = database._file
        with file.transaction("IMMEDIATE"):
            for table, row in _rows(entry, entries):
                checked = with_checksum(row)
                marks = ", ".join("?" for _ in checked)
                file.execute(
                    f"INSERT INTO {table} ({', '.join(checked)}) VALUES ({marks})",
                    tuple(checked.values()),
                )


def _rows(template: Entry, entries: int) -> Iterator[tuple[str, dict[str, Any]]]:
    first = replace(template, identifier=1)
    of_entry, of_event = entry_columns(first), event_columns(first, 1, "recorded")
    of_iterations = [iteration_columns(1, 1, each) for each in template.iterations]
    for number in range(1, entries + 1):
        yield "entry", {**of_entry, "id": number, "parameters": encode(squat(number))}
        yield "event", {**of_event, "id": number, "entry": number}
        for columns in of_iterations:
            yield "iteration", {**columns, "entry": number, "event": number}
