"""A log in another format."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.state import Vector
from tsd_casadi.whole_file import write_whole
from tsd_casadi.wire.run_outline import RunOutline
from tsd_clients.logs.log import Log
from tsd_clients.logs.log_file import MCAP, check_log_path, write_log
from tsd_clients.logs.ros_messages import MORE_FIELDS

# ticks that are turned into messages at once
BATCH = 256


def write_any_log(log: Log, path: Path) -> None:
    """Write a log into the format that the ending of the file names.

    As .mcap it has in float64 what the log has in less, begins in 1970 for want of a
    date, and lacks what was measured where the log has what was true only.

    Raises:
        InvalidValue: If the file cannot be written, or as .mcap if the log does not
            tell of what it is.
        NotAvailable: If the library of its format is not installed.
        TsdError: If it is to be a .mcap and the robot's files cannot be used.
    """
    check_log_path(path)
    if path.suffix.lower() != MCAP:
        write_log(log, path)
        return
    if log.outline is None:
        raise InvalidValue(
            "log",
            "one that does not tell robot, motion and joints",
            "an .npz that 'tsd simulate --log' wrote; a .csv has columns only",
        )
    from tsd_clients.logs.mcap_file import begin_mcap
    from tsd_clients.logs.mcap_recording import McapRecording

    columns = _columns(log, log.outline)
    with write_whole(path) as file:
        recording = McapRecording(begin_mcap(file), log.outline, 0)
        for start in range(0, log.ticks, BATCH):
            ticks = slice(start, start + BATCH)
            recording.add_ticks({name: values[ticks] for name, values in columns.items()})
        if log.infeasible_request is not None:
            recording.add_request(log.infeasible_request.tobytes())
        recording.finish(log.summary)


def _columns(log: Log, outline: RunOutline) -> dict[str, Vector]:
    columns = {
        name: values.astype(float)
        for name, values in {**log.fields, **log.more}.items()
        if name != "measured"
    }
    n = len(outline.known.joints)
    sizes = {"(7 + n,)": 7 + n, "(6 + n,)": 6 + n, "(rows,)": len(outline.known.row_names)}
    for name, field in MORE_FIELDS.items():
        shape = (log.ticks,) if field.shape == "()" else (log.ticks, sizes[field.shape])
        columns.setdefault(name, np.full(shape, np.nan))
    assert columns.keys() >= LOG_FIELDS.keys() - {"measured"}
    return columns
