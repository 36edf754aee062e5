"""Ticks of a run by quantity, however they arrived."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from tsd_casadi.state import Matrix, Vector
from tsd_casadi.tick.layout import Layout
from tsd_casadi.wire.run_outline import RunOutline
from tsd_clients.logs.log import Log


@dataclass(frozen=True)
class Ticks:
    """Some ticks in a row, the newest last; the first axis of every array is the tick.

    Attributes:
        time: Since the repetition began, (T,) [s].
        lap: -1 while holding, (T,).
        q: Configuration as measured, (T, nq).
        true_q: True configuration; NaN where nobody knows it.
        reference: Of the axes of the repetition, relative to the motion's middle, (T, k).
        error: Of these axes, as the controller sees it, (T, k) [m, rad].
        true_error: Of these axes; NaN where nobody knows it.
        feedback: (T, k) [m/s^2, rad/s^2].
        feedforward: (T, k) [m/s^2, rad/s^2].
        all_errors: Of all axes of all tasks, (T, a) [m, rad].
        tau: Commanded joint torques, (T, n) [N m].
        wrenches: Planned contact wrenches, (T, c, 6) [N, N m].
        bounds: What bounds each row of ``limit_rows``, as in a reply's ``active``, (T, r).
        status: How the tick ended, -1 without an answer, (T,).
        tick_us: Round trip, the longest since the tick before, (T,) [us].
    """

    time: Vector
    lap: Vector
    q: Matrix
    true_q: Matrix
    reference: Matrix
    error: Matrix
    true_error: Matrix
    feedback: Matrix
    feedforward: Matrix
    all_errors: Matrix
    tau: Matrix
    wrenches: Vector
    bounds: Matrix
    status: Vector
    tick_us: Vector

    def __len__(self) -> int:
        """Count the ticks."""
        return len(self.time)

    def part(self, start: int, stop: int, step: int = 1) -> Ticks:
        """Take some of them; no copies."""
        cut = slice(start, stop, step)
        return Ticks(**{field.name: getattr(self, field.name)[cut] for field in fields(self)})


class RowReader:
    """Reads rows of a run that publishes itself."""

    def __init__(self, outline: RunOutline, layout: Layout) -> None:
        """Look up where everything is.

        Args:
            layout: Of a row: that of the outline, and more behind it.
        """
        known = outline.known
        self._layout = layout.slices
        start = layout.slice("reply").start
        self._reply = {
            name: slice(start + part.start, start + part.stop)
            for name, part in known.reply.slices.items()
        }
        pairs = [axis.rpartition(".")[::2] for axis in outline.axes]
        self._axes = np.array([known.axis_index(task, axis) for task, axis in pairs], dtype=int)

    def ticks(self, rows: Matrix) -> Ticks:
        """Read rows.

        Args:
            rows: (T, layout.size).
        """
        column = {name: rows[:, place] for name, place in self._layout.items()}
        reply = {name: rows[:, place] for name, place in self._reply.items()}
        return Ticks(
            time=column["time"][:, 0],
            lap=column["lap"][:, 0],
            q=column["q"],
            true_q=column["true_q"],
            reference=column["reference"],
            error=reply["error"][:, self._axes],
            true_error=column["true_error"],
            feedback=reply["feedback"][:, self._axes],
            feedforward=column["feedforward"],
            all_errors=reply["error"],
            tau=column["tau"],
            wrenches=reply["wrenches"].reshape(len(rows), -1, 6),
            bounds=np.nan_to_num(reply["active"]),
            status=np.nan_to_num(rows[:, self._reply["status"].start], nan=-1.0),
            tick_us=column["tick_us_largest"][:, 0],
        )


def ticks_of_log(log: Log) -> Ticks:
    """Read a log; it has the true configuration only."""
    fields = log.fields
    count = len(fields["time"])
    q = fields["q"].astype(float)
    return Ticks(
        q=q,
        true_q=q,
        wrenches=fields["wrenches"].astype(float).reshape(count, -1, 6),
        bounds=fields["joint_limits"],
        **{
            name: fields[name]
            for name in (
                *("time", "lap", "reference", "error", "true_error", "feedback", "feedforward"),
                *("all_errors", "tau", "status", "tick_us"),
            )
        },
    )


def limit_rows_of_log(joints: Sequence[str]) -> tuple[str, ...]:
    """Name the rows that a log tells about: the joints' accelerations."""
    return tuple(f"joint_acceleration.{joint}" for joint in joints)
