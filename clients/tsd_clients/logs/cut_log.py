"""A part of a log: some of its time, or some of its laps."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.tick.format import Status
from tsd_casadi.whole_file import write_whole
from tsd_clients.logs.convert_log import write_any_log
from tsd_clients.logs.log import Log
from tsd_clients.logs.log_file import MCAP

Ticks = NDArray[np.bool_]


def ticks_between(log: Log, first: float | None, last: float | None) -> Ticks:
    """Find the ticks from one time to another, both included [s]."""
    time = log.fields["time"]
    begin, end = (-np.inf if first is None else first), (np.inf if last is None else last)
    return np.asarray((time >= begin) & (time <= end))


def ticks_of_laps(log: Log, first: int, last: int) -> Ticks:
    """Find the ticks of laps, first and last included."""
    lap = log.fields["lap"]
    return np.asarray((lap >= first) & (lap <= last))


def part_of(log: Log, ticks: Ticks) -> Log:
    """Keep some ticks of a log; what it says of the whole run stays."""
    return dataclasses.replace(
        log,
        fields={name: values[ticks] for name, values in log.fields.items()},
        more={name: values[ticks] for name, values in log.more.items()},
        infeasible_request=log.infeasible_request if _keeps_request(log, ticks) else None,
    )


def cut_log(source: Path, target: Path, log: Log, ticks: Ticks) -> None:
    """Write some ticks of a log into another file; from .mcap to .mcap message by message.

    Args:
        source: The file of the log.
        target: Ends in .csv, .npz or .mcap.
        log: As read from it.
        ticks: Which of its ticks, one after another.

    Raises:
        InvalidValue: If there are none, or the target cannot be written.
    """
    if not ticks.any():
        raise InvalidValue("part of the log", "without a tick", _what_there_is(log))
    if not source.suffix.lower() == target.suffix.lower() == MCAP:
        write_any_log(part_of(log, ticks), target)
        return
    from tsd_clients.logs.copy_mcap import copy_mcap
    from tsd_clients.logs.mcap_file import REQUEST, begin_mcap
    from tsd_clients.logs.read_mcap import beginning_of

    began, times = beginning_of(source), log.fields["time"][ticks]
    span = began + round(1e9 * times[0]), began + round(1e9 * times[-1])
    keeps_request = _keeps_request(log, ticks)
    with source.open("rb") as file, write_whole(target) as out:
        copy_mcap(file, begin_mcap(out), span, lambda name: keeps_request or name != REQUEST)


def _keeps_request(log: Log, ticks: Ticks) -> bool:
    """Whether the tick whose state and command are kept whole is among those."""
    infeasible = np.flatnonzero(log.fields["status"] == Status.INFEASIBLE)
    return bool(infeasible.size and ticks[infeasible[0]])


def _what_there_is(log: Log) -> str:
    if not log.ticks:
        return "a log with ticks"
    time, lap = log.fields["time"], log.fields["lap"]
    return f"a part of {time[0]:.3f} to {time[-1]:.3f} s, laps {lap.min()} to {lap.max()}"
