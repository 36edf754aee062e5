"""The log of a run, read back from an MCAP file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from mcap.reader import McapReader, make_reader

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.exceptions.logs import LogNotWhole
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_casadi.state import Vector
from tsd_casadi.wire.run_outline import RunOutline
from tsd_clients.logs import ros_messages
from tsd_clients.logs.log import Log
from tsd_clients.logs.mcap_file import OUTLINE, REQUEST, SUMMARY, TICK_TOPIC
from tsd_clients.logs.ros_messages import MORE_FIELDS
from tsd_clients.logs.run_summary import measured_ticks
from tsd_clients.logs.tick_columns import column_sizes


def read_mcap(path: Path) -> Log:
    """Read a log.

    Raises:
        InvalidValue: If it is none of ours.
        LogNotWhole: If it ends in the middle, or a checksum is wrong.
        OSError: If it cannot be read.
    """
    with _reader_of(path) as reader:
        attached = {each.name: each.data for each in reader.iter_attachments()}
        messages = [
            message.data
            for _, _, message in reader.iter_messages(topics=[TICK_TOPIC], log_time_order=False)
        ]
    if OUTLINE not in attached:
        raise InvalidValue("log file", f"'{path}'", "one that 'tsd simulate --log' wrote")
    outline = RunOutline.decode(attached[OUTLINE])
    summary = json.loads(attached.get(SUMMARY, b"{}"))
    columns = ros_messages.tick(column_sizes(outline)).read(messages)
    fields = {
        name: _column(columns[name], field.shape).astype(field.type)
        for name, field in LOG_FIELDS.items()
        if name in columns
    }
    fields["measured"] = measured_ticks(fields, summary)
    request = attached.get(REQUEST)
    return Log(
        fields=fields,
        axes=outline.axes,
        robot=outline.robot,
        model=outline.model,
        infeasible_request=None if request is None else np.frombuffer(request, "<f8").copy(),
        outline=outline,
        summary=summary,
        more={name: _column(columns[name], field.shape) for name, field in MORE_FIELDS.items()},
    )


def beginning_of(path: Path) -> int:
    """Tell when the time of a log was 0 [ns since 1970]."""
    with _reader_of(path) as reader:
        return next(each.log_time for each in reader.iter_attachments() if each.name == OUTLINE)


@contextmanager
def _reader_of(path: Path) -> Iterator[McapReader]:
    with path.open("rb") as file:
        try:
            yield make_reader(file, validate_crcs=True)
        except OSError:
            raise
        except Exception as error:  # whatever a parser or decompressor says of damaged bytes
            raise LogNotWhole(path, str(error) or type(error).__name__) from error


def _column(values: Vector, shape: str) -> Vector:
    return values[:, 0] if shape == "()" else values
