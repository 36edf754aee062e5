"""One repetition as a film shows it, a moment for each picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.robot.ghost import error_axes, ghost_posture
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, Vector
from tsd_clients.film.force_arrows import force_arrows

SIGNALS = ("error", "feedback", "feedforward")


@dataclass(frozen=True)
class Clip:
    """What is seen of a repetition, N moments.

    Attributes:
        label: What it is, for people: 'iteration 2'; may be empty.
        axes: Names 'task.axis' of what is plotted, k of them.
        rms: Of the error along each axis where it was measured, (k,) [m, rad]; NaN
            where nothing was.
        rate: Moments a second [1/s].
        time: Since the repetition began, (N,) [s].
        lap: Number of the lap, (N,); -1 while holding.
        q: True configuration, (N, nq).
        ghosts: Where the tasks' errors would be zero, (N, nq).
        arrows: Of the contact forces, (N, c, 2, 3) [m], world frame.
        signals: By the names of ``SIGNALS``, (N, k) each [m, rad; m/s^2, rad/s^2].
    """

    label: str
    axes: tuple[str, ...]
    rms: Vector
    rate: float
    time: Vector
    lap: Vector
    q: Matrix
    ghosts: Matrix
    arrows: Matrix
    signals: dict[str, Matrix]

    @property
    def seconds(self) -> float:
        """How long it takes [s]."""
        return len(self.time) / self.rate


def make_clip(
    robot: Robot,
    fields: Mapping[str, Vector],
    axes: Sequence[str],
    *,
    rate: float,
    label: str = "",
    plotted: int | None = None,
) -> Clip:
    """Choose the moments of a repetition that a film shows.

    Args:
        fields: As of a log, see ``LOG_FIELDS``.
        axes: Names 'task.axis' of its axes.
        rate: Pictures a second [1/s].
        label: What it is, for people.
        plotted: The first so many axes are; all by default.

    Raises:
        InvalidValue: If the log is of another robot, or empty.
    """
    sizes = {"q": robot.nq, "wrenches": 6 * len(robot.feet), "all_errors": len(error_axes(robot))}
    found = {name: fields[name].shape[1:] for name in sizes}
    if found != {name: (size,) for name, size in sizes.items()} or not len(fields["time"]):
        raise InvalidValue(
            "the log", f"not one of {robot.name}, or empty", "another --robot, or another log"
        )
    time = fields["time"]
    begin, count = time[0], int(np.floor((time[-1] - time[0]) * rate)) + 1
    ticks = np.searchsorted(time, begin + np.arange(count) / rate - 1e-9)
    shown = slice(None, plotted)
    q = np.array(fields["q"][ticks], dtype=float)
    q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1, keepdims=True)
    # what nobody answered is not known: no arrow, and no ghost apart from the robot
    errors, wrenches = (
        np.nan_to_num(np.array(fields[name][ticks], dtype=float))
        for name in ("all_errors", "wrenches")
    )
    names = error_axes(robot)
    with np.errstate(invalid="ignore"):
        measured = fields["error"][fields["measured"]][:, shown]
    return Clip(
        label=label,
        axes=tuple(axes)[shown],
        rms=np.sqrt((measured**2).sum(axis=0) / (len(measured) or np.nan)),
        rate=rate,
        time=time[ticks],
        lap=fields["lap"][ticks],
        q=q,
        ghosts=np.array(
            [
                ghost_posture(robot, here, dict(zip(names, error, strict=True)), axes)
                for here, error in zip(q, errors, strict=True)
            ]
        ),
        arrows=np.array([force_arrows(robot, *each) for each in zip(q, wrenches, strict=True)]),
        signals={name: np.array(fields[name][ticks][:, shown], dtype=float) for name in SIGNALS},
    )


def last_lap(fields: Mapping[str, Vector]) -> dict[str, Vector]:
    """Take the last lap of a log out of it; all of it where there was none."""
    lap = fields["lap"]
    return {name: values[lap == lap.max()] for name, values in fields.items()}
