"""The log of a repetition that is over as a file: compressed NumPy arrays, or CSV."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.repetition.run import Run
from tsd_casadi.whole_file import write_whole
from tsd_casadi.wire.run_outline import RunOutline
from tsd_clients.extra import require_extra
from tsd_clients.logs.log import Log
from tsd_clients.logs.run_summary import run_summary

WRITERS = (".csv", ".npz")
MCAP = ".mcap"
ENDINGS = (*WRITERS, MCAP)


def save_log(run: Run, path: str | Path, outline: RunOutline | None = None) -> None:
    """Write every tick of a run; the ending of the path says how.

    A .mcap is written while the robot moves, by ``McapLog``.

    Args:
        path: Ends in .npz for one array a field and what ``Log`` has besides, or in
            .csv for one line a tick and one column a component: 'error[com.z]' of
            an axis, 'tau[0]' of other fields.
        outline: What the repetition said of itself; an .npz has it, too.

    Raises:
        InvalidValue: If the ending is another one, or the file cannot be written.
    """
    write_log(log_of(run, outline), path)


def log_of(run: Run, outline: RunOutline | None = None) -> Log:
    """Give the log of a run that is over."""
    return Log(
        fields=run.log,
        axes=run.axes,
        robot=run.robot,
        model=run.model,
        infeasible_request=run.infeasible_request,
        outline=outline,
        summary=run_summary(run),
    )


def write_log(log: Log, path: str | Path) -> None:
    """Write a log as .npz or .csv.

    Raises:
        InvalidValue: If the ending is another one, or the file cannot be written.
    """
    write = _write_npz if _ending(path, WRITERS) == ".npz" else _write_csv
    with write_whole(path) as file:
        write(log, file)


def check_log_path(path: str | Path) -> None:
    """Refuse the name of a file that no log can have.

    Raises:
        InvalidValue: If its ending is not the one of a format.
        NotAvailable: If the library of its format is not installed.
    """
    if _ending(path, ENDINGS) == MCAP:
        require_extra("view", "a log as .mcap", "mcap")


def _ending(path: str | Path, known: Sequence[str]) -> str:
    ending = Path(path).suffix.lower()
    if ending not in known:
        raise InvalidValue(
            "log file", f"'{path}'", f"a name that ends in {' or '.join(sorted(known))}"
        )
    return ending


def _write_npz(log: Log, file: BinaryIO) -> None:
    texts = {"robot": log.robot, "model": log.model, "summary": json.dumps(log.summary)}
    if log.outline is not None:
        texts["outline"] = log.outline.encode().decode()
    more = {"axes": np.array(log.axes), **{name: np.array(text) for name, text in texts.items()}}
    if log.infeasible_request is not None:
        more["infeasible_request"] = log.infeasible_request
    np.savez_compressed(file, **log.fields, **log.more, **more)  # type: ignore[arg-type]


def _write_csv(log: Log, file: BinaryIO) -> None:
    columns: dict[str, list[str]] = {}
    for name, values in log.fields.items():
        # shortest text that gives the same number; 0 and 1 instead of False and True
        texts = (values.astype(int) if values.dtype == bool else values).astype(str)
        if texts.ndim == 1:
            columns[name] = texts.tolist()
        else:
            field = LOG_FIELDS.get(name)
            of_axes = field is not None and field.shape == "(k,)"
            parts = log.axes if of_axes else range(texts.shape[1])
            columns |= {
                f"{name}[{part}]": column.tolist()
                for part, column in zip(parts, texts.T, strict=True)
            }
    text = io.TextIOWrapper(file, encoding="ascii", newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    text.detach()  # written out, and the file stays open for whoever opened it
