"""The log of a repetition, read back from its file."""

from __future__ import annotations

import csv
import json
import zipfile
from pathlib import Path

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.state import Vector
from tsd_casadi.wire.run_outline import RunOutline
from tsd_clients.logs.log import Log
from tsd_clients.logs.log_file import check_log_path
from tsd_clients.logs.ros_messages import MORE_FIELDS


def read_log(path: Path) -> Log:
    """Read a log.

    Raises:
        InvalidValue: If it is not one, or has not all fields.
        LogNotWhole: If it ends in the middle.
        NotAvailable: If the library of its format is not installed.
        OSError: If it cannot be read.
    """
    check_log_path(path)
    try:
        log = _READERS[path.suffix.lower()](path)
    except (ValueError, KeyError, IndexError, zipfile.BadZipFile) as error:
        raise InvalidValue(
            "log file", f"'{path}' ({error})", "one that 'tsd simulate --log' wrote"
        ) from error
    missing = [name for name in LOG_FIELDS if name not in log.fields]
    if missing:
        raise InvalidValue(
            "log file", f"'{path}' without {', '.join(missing)}", "all fields of docs/logs.md"
        )
    return log


def _read_npz(path: Path) -> Log:
    with np.load(path, allow_pickle=False) as saved:
        names = set(saved)
        outline = str(saved["outline"]) if "outline" in names else None
        return Log(
            fields={name: saved[name] for name in LOG_FIELDS if name in names},
            axes=tuple(saved["axes"].tolist()),
            robot=str(saved["robot"]) if "robot" in names else "",
            model=str(saved["model"]) if "model" in names else "",
            infeasible_request=(
                saved["infeasible_request"] if "infeasible_request" in names else None
            ),
            outline=None if outline is None else RunOutline.decode(outline.encode()),
            summary=json.loads(str(saved["summary"])) if "summary" in names else {},
            more={name: saved[name] for name in MORE_FIELDS if name in names},
        )


def _read_csv(path: Path) -> Log:
    with path.open(newline="", encoding="ascii") as file:
        header, *lines = list(csv.reader(file))
    numbers = np.array(lines, dtype=float).reshape(-1, len(header))
    columns: dict[str, list[Vector]] = {}
    axes = []
    for title, column in zip(header, numbers.T, strict=True):
        name, _, part = title.partition("[")
        columns.setdefault(name, []).append(column)
        if name == "reference":
            axes.append(part.rstrip("]"))
    fields = {}
    for name, field in LOG_FIELDS.items():
        if name in columns:
            values = np.array(columns[name])
            fields[name] = (values[0] if field.shape == "()" else values.T).astype(field.type)
    return Log(fields, tuple(axes))


def _read_mcap(path: Path) -> Log:
    from tsd_clients.logs.read_mcap import read_mcap

    return read_mcap(path)


_READERS = {".csv": _read_csv, ".npz": _read_npz, ".mcap": _read_mcap}
