"""The log of a repetition as a file: compressed NumPy arrays, or CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.repetition.run import Run
from tsd_casadi.whole_file import write_whole


def save_log(run: Run, path: str | Path) -> None:
    """Write every tick of a run; the ending of the path says how.

    Args:
        path: Ends in .npz for one array a field and what ``Log`` has besides, or in
            .csv for one line a tick and one column a component: 'error[com.z]' of
            an axis, 'tau[0]' of other fields.

    Raises:
        InvalidValue: If the ending is another one, or the file cannot be written.
    """
    write = _writer(path)
    with write_whole(path) as file:
        write(run, file)


def check_log_path(path: str | Path) -> None:
    """Refuse the name of a file that no log can have.

    Raises:
        InvalidValue: If its ending is not the one of a format.
    """
    _writer(path)


def _writer(path: str | Path) -> Callable[[Run, BinaryIO], None]:
    ending = Path(path).suffix.lower()
    if ending not in WRITERS:
        raise InvalidValue(
            "log file", f"'{path}'", f"a name that ends in {' or '.join(sorted(WRITERS))}"
        )
    return WRITERS[ending]


def _write_npz(run: Run, file: BinaryIO) -> None:
    more = {"axes": np.array(run.axes), "robot": np.array(run.robot), "model": np.array(run.model)}
    if run.infeasible_request is not None:
        more["infeasible_request"] = run.infeasible_request
    np.savez_compressed(file, **run.log, **more)  # type: ignore[arg-type]


def _write_csv(run: Run, file: BinaryIO) -> None:
    columns: dict[str, list[str]] = {}
    for name, values in run.log.items():
        # shortest text that gives the same number; 0 and 1 instead of False and True
        texts = (values.astype(int) if values.dtype == bool else values).astype(str)
        if texts.ndim == 1:
            columns[name] = texts.tolist()
        else:
            field = LOG_FIELDS.get(name)
            of_axes = field is not None and field.shape == "(k,)"
            parts = run.axes if of_axes else range(texts.shape[1])
            columns |= {
                f"{name}[{part}]": column.tolist()
                for part, column in zip(parts, texts.T, strict=True)
            }
    text = io.TextIOWrapper(file, encoding="ascii", newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    text.detach()  # written out, and the file stays open for whoever opened it


WRITERS = {".npz": _write_npz, ".csv": _write_csv}
