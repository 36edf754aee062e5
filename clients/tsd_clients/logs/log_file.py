"""The log of a repetition as a file: compressed NumPy arrays, or CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import BinaryIO

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.run import Run
from tsd_casadi.state import Vector
from tsd_casadi.whole_file import write_whole

Log = Mapping[str, Vector]


def save_log(run: Run, path: str | Path) -> None:
    """Write every tick of a run; the ending of the path says how.

    Args:
        path: Ends in .npz for one array a field, or in .csv for one line a tick
            and one column a component, 'tau[0]' and so on.

    Raises:
        InvalidValue: If the ending is another one, or the file cannot be written.
    """
    write = _writer(path)
    with write_whole(path) as file:
        write(run.log, file)


def check_log_path(path: str | Path) -> None:
    """Refuse the name of a file that no log can have.

    Raises:
        InvalidValue: If its ending is not the one of a format.
    """
    _writer(path)


def _writer(path: str | Path) -> Callable[[Log, BinaryIO], None]:
    ending = Path(path).suffix.lower()
    if ending not in WRITERS:
        raise InvalidValue(
            "log file", f"'{path}'", f"a name that ends in {' or '.join(sorted(WRITERS))}"
        )
    return WRITERS[ending]


def _write_npz(log: Log, file: BinaryIO) -> None:
    np.savez_compressed(file, **log)  # type: ignore[arg-type]


def _write_csv(log: Log, file: BinaryIO) -> None:
    columns: dict[str, list[str]] = {}
    for name, values in log.items():
        # shortest text that gives the same number; 0 and 1 instead of False and True
        texts = (values.astype(int) if values.dtype == bool else values).astype(str)
        if texts.ndim == 1:
            columns[name] = texts.tolist()
        else:
            columns |= {f"{name}[{i}]": column.tolist() for i, column in enumerate(texts.T)}
    text = io.TextIOWrapper(file, encoding="ascii", newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    text.detach()  # written out, and the file stays open for whoever opened it


WRITERS = {".npz": _write_npz, ".csv": _write_csv}
