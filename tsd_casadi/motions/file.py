"""A motion from a file: references of some axes over one lap.

A .csv has a column ``time`` [s] and one for each axis, ``com.x`` or ``torso.rz``,
offsets from the middle of the motion [m, rad]; an .npz has arrays of these names.
The last line is the first of the next lap. In between is a periodic cubic spline
over the phase, whose own derivatives are the references'.
"""

from __future__ import annotations

import csv
import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.motions.motion import Motion, Offset
from tsd_casadi.motions.parameter import parameter
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector

FEWEST = 5  # times, so that a cubic means something
# between two times, in medians of all steps: more is a gap
GAP = 3.0
# of an axis' span: further apart the ends of a lap do not meet
APART = 1e-3


@dataclass(frozen=True)
class File(Motion):
    """What a file with references says, as often and as large as asked for.

    Attributes:
        scale: Factor on the file's offsets.
        frequency: Laps per second [Hz]; by default as the file's times say.
    """

    scale: float = parameter("1", "factor on the file's offsets", default=1.0, low=0.0, extent=True)
    frequency: float = parameter("Hz", "laps per second; the file's own if left out", default=0.25)

    name = "file"
    # of the file, set by ``motion_of_file``
    columns: ClassVar[tuple[str, ...]] = ()
    spline: ClassVar[Any] = None

    def axes(self, robot: Robot) -> tuple[str, ...]:
        """Name the file's columns.

        Raises:
            InvalidValue: If no file was given, or the robot has no such axis.
        """
        if self.spline is None:
            raise InvalidValue("motion", "'file'", "the name of one: wave.csv or wave.npz")
        tasks = robot.description.tasks
        there = [f"{part.name}.{axis}" for part in tasks for axis in part.axes]
        for column in self.columns:
            if column not in there:
                raise InvalidValue(
                    "column", f"'{column}'", f"an axis of {robot.name}: {', '.join(there)}"
                )
        return self.columns

    def offset(self, phase: float) -> Offset:
        """Evaluate the spline and its derivatives."""
        wrapped = phase % (2 * math.pi)
        return Offset(*(self.scale * self.spline(wrapped, order) for order in range(3)))


def motion_of_file(path: Path) -> type[File]:
    """Make a motion's class of a file with references.

    Its version is that of the numbers: other numbers are another motion.

    Args:
        path: Ends in .csv or .npz.

    Raises:
        InvalidValue: If it cannot be read, has gaps, NaN, unsorted times or ends
            that do not meet; it names file and column.
    """
    # slow to load, and only used here
    from scipy.interpolate import CubicSpline

    table = _read_csv(path) if path.suffix.lower() == ".csv" else _read_npz(path)
    time = _check_time(path, table)
    columns = tuple(name for name in table if name != "time")
    values = np.column_stack([_check_column(path, name, table[name], time) for name in columns])
    values[-1] = values[0]
    duration = float(time[-1] - time[0])
    phases = 2 * math.pi * (time - time[0]) / duration
    digest = hashlib.sha256(repr(columns).encode())
    digest.update(np.round(phases, 9).tobytes() + (np.round(values, 9) + 0.0).tobytes())

    @dataclass(frozen=True)
    class Replay(File):
        """The motion of one file."""

        frequency: float = parameter(
            "Hz", "laps per second", default=round(1 / duration, 6), low=1e-3
        )

    Replay.version = digest.hexdigest()[:12]
    Replay.columns, Replay.spline = columns, CubicSpline(phases, values, bc_type="periodic")
    return Replay


def _read_csv(path: Path) -> dict[str, Vector]:
    try:
        with path.open(newline="", encoding="utf-8") as file:
            header, *rows = [row for row in csv.reader(file) if row]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InvalidValue("motion", f"'{path}', which cannot be read ({error})", "a CSV") from None
    except ValueError:
        raise InvalidValue("motion", f"'{path}', which is empty", "a line of names") from None
    names = [name.strip() for name in header]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InvalidValue(f"{path}: column '{twice}'", "there twice", "each name once")
    table = []
    for number, row in enumerate(rows, start=2):
        if len(row) != len(names):
            raise InvalidValue(
                f"{path}: line {number}", f"of {len(row)} cells", f"{len(names)}, one a column"
            )
        for name, cell in zip(names, row, strict=True):
            try:
                float(cell)
            except ValueError:
                raise InvalidValue(
                    f"{path}: column '{name}', line {number}", repr(cell), "a number"
                ) from None
        table.append([float(cell) for cell in row])
    return dict(zip(names, np.array(table).reshape(-1, len(names)).T, strict=True))


def _read_npz(path: Path) -> dict[str, Vector]:
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return {name: np.asarray(arrays[name], dtype=float) for name in arrays.files}
    except (OSError, ValueError, TypeError) as error:
        raise InvalidValue(
            "motion", f"'{path}', which cannot be read ({error})", "an .npz of numbers"
        ) from None


def _check_time(path: Path, table: Mapping[str, Vector]) -> Vector:
    names = ", ".join(table) or "nothing"
    if "time" not in table:
        raise InvalidValue(f"{path}: columns", names, "'time' and axes such as 'com.x'")
    if len(table) < 2:
        raise InvalidValue(f"{path}: columns", names, "an axis as well, such as 'com.x'")
    time = table["time"]
    if time.ndim != 1 or len(time) < FEWEST:
        raise InvalidValue(f"{path}: time", f"of {len(time)} values", f"at least {FEWEST}")
    _check_finite(path, "time", time)
    steps = np.diff(time)
    if (steps <= 0).any():
        at = int(np.argmax(steps <= 0))
        raise InvalidValue(
            f"{path}: time", f"{time[at + 1]:g} s after {time[at]:g} s", "times that grow"
        )
    if (steps > GAP * np.median(steps)).any():
        at = int(np.argmax(steps))
        raise InvalidValue(
            f"{path}: time",
            f"without anything from {time[at]:g} to {time[at + 1]:g} s",
            f"no gap above {GAP:g} usual steps of {np.median(steps):g} s",
        )
    return time


def _check_column(path: Path, name: str, values: Vector, time: Vector) -> Vector:
    if "." not in name:
        raise InvalidValue(f"{path}: column '{name}'", "no axis", "'task.axis', such as 'com.x'")
    if values.shape != time.shape:
        raise InvalidValue(f"{path}: column '{name}'", f"of {values.size} values", f"{time.size}")
    _check_finite(path, name, values)
    span = float(np.ptp(values))
    if abs(values[-1] - values[0]) > max(APART * span, 1e-9):
        raise InvalidValue(
            f"{path}: column '{name}'",
            f"{values[0]:g} at its start and {values[-1]:g} at its end",
            "ends that meet: the last line is the first of the next lap",
        )
    return values


def _check_finite(path: Path, name: str, values: Vector) -> None:
    wrong = ~np.isfinite(values)
    if wrong.any():
        at = int(np.argmax(wrong))
        raise InvalidValue(
            f"{path}: column '{name}', value {at + 1}", f"{values[at]:g}", "a finite number"
        )
