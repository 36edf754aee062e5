"""Rows of ticks as the columns of a log."""

from __future__ import annotations

import numpy as np

from tsd_casadi.repetition.tick_log import NO_STATUS
from tsd_casadi.state import Matrix, Vector
from tsd_casadi.wire.run_outline import RunOutline


def tick_columns(rows: Matrix, outline: RunOutline) -> dict[str, Vector]:
    """Pick what a log has out of rows.

    Args:
        rows: (N, outline.layout.size).

    Returns:
        float64 by name of ``TICK_FIELDS``: scalars (N,), others (N, components).
    """
    layout, known = outline.layout, outline.known
    reply = rows[:, layout.slice("reply")]

    def part(name: str) -> Matrix:
        return rows[:, layout.slice(name)]

    def answered(name: str) -> Matrix:
        return reply[:, known.reply.slice(name)]

    pairs = [axis.rpartition(".")[::2] for axis in outline.axes]
    index = [known.axis_index(task, axis) for task, axis in pairs]
    active = answered("active")
    # the rows of the joints follow those of the base's six accelerations
    joints = active[:, 6 : 6 + len(known.joints)]
    times = sum(answered(name)[:, 0] for name in ("data_time", "factorization_time", "solve_time"))
    # what one knows best
    q, v = (
        np.where(np.isnan(part(f"true_{name}")), part(name), part(f"true_{name}"))
        for name in ("q", "v")
    )
    return {
        **{name: part(name)[:, 0] for name in ("time", "phase", "lap", "share", "missed")},
        "reference": part("reference"),
        "error": answered("error")[:, index],
        "true_error": part("true_error"),
        "feedback": answered("feedback")[:, index],
        "feedforward": part("feedforward"),
        "all_errors": answered("error"),
        "q": q,
        "v": v,
        "tau": part("tau"),
        "wrenches": answered("wrenches"),
        "joint_limits": np.nan_to_num(joints),
        "status": np.nan_to_num(answered("status")[:, 0], nan=NO_STATUS),
        "compute_us": np.asarray(times),
        "tick_us": part("tick_us")[:, 0],
        "measured_q": part("q"),
        "measured_v": part("v"),
        "active": active,
    }


def column_sizes(outline: RunOutline) -> dict[str, int]:
    """Count the components of every field that is an array, by name."""
    nothing = tick_columns(np.zeros((1, outline.layout.size)), outline)
    return {name: values.shape[1] for name, values in nothing.items() if values.ndim > 1}
