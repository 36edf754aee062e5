"""A log as one picture: errors, feedback and feedforward by axis, torques against limits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.whole_file import write_whole
from tsd_clients.logs.log import Log

ENDINGS = (".pdf", ".png", ".svg")
# joints with a line of their own; the picture is for the few that come near their limits
NAMED_JOINTS = 6


def check_picture_path(path: Path) -> None:
    """Refuse the name of a file that no picture can have.

    Raises:
        InvalidValue: If its ending is another one.
    """
    if path.suffix.lower() not in ENDINGS:
        raise InvalidValue("picture", f"'{path}'", f"a name that ends in {' or '.join(ENDINGS)}")


def plot_log(log: Log, path: Path) -> None:
    """Draw a log.

    Args:
        path: The picture; its ending says how.

    Raises:
        InvalidValue: If there is no tick, or the picture cannot be written.
    """
    from matplotlib.figure import Figure

    check_picture_path(path)
    if not log.ticks:
        raise InvalidValue("log", "without a tick", "one to draw")
    rows = len(log.axes) + 1
    figure = Figure(figsize=(12.0, 1.0 + 2.2 * rows), layout="constrained")
    axes = figure.subplots(rows, 2, sharex=True, squeeze=False)
    for place, axis in enumerate(log.axes):
        _draw_axis(log, place, axis, *axes[place])
    torques, wrenches = axes[-1]
    _draw_torques(log, torques)
    _draw_forces(log, wrenches)
    for each in axes.flat:
        _shade_measured(log, each)
        each.grid(alpha=0.3)
    for each in axes[-1]:
        each.set_xlabel("time [s]")
    figure.suptitle(_title(log))
    with write_whole(path) as file:
        figure.savefig(file, format=path.suffix.lower().lstrip("."), dpi=120)


def _draw_axis(log: Log, place: int, axis: str, errors: Any, accelerations: Any) -> None:
    fields, unit = log.fields, unit_of_axis(axis)
    time = fields["time"]
    errors.plot(time, 1e3 * fields["error"][:, place], lw=0.8, label="as the controller sees it")
    true_error = fields["true_error"][:, place]
    if not np.isnan(true_error).all():
        errors.plot(time, 1e3 * true_error, lw=0.8, label="true")
    errors.set_ylabel(f"{axis}\nerror [m{unit}]")
    errors.legend(loc="upper right", fontsize="small")
    for name in ("feedback", "feedforward"):
        accelerations.plot(time, fields[name][:, place], lw=0.8, label=name)
    accelerations.set_ylabel(f"[{unit}/s²]")
    accelerations.legend(loc="upper right", fontsize="small")


def _draw_torques(log: Log, axes: Any) -> None:
    """Draw the torques as shares of their limits, where the log tells those."""
    tau, outline = log.fields["tau"], log.outline
    joints = [str(place) for place in range(tau.shape[1])]
    if outline is not None:
        tau, joints = tau / np.array(outline.torque_limits), list(outline.known.joints)
        axes.set_ylim(-1.1, 1.1)
        for limit in (-1.0, 1.0):
            axes.axhline(limit, color="black", lw=0.8, ls="--")
    nearest = np.argsort(-np.nanmax(np.abs(tau), axis=0))
    for rank, joint in enumerate(nearest):
        named = rank < NAMED_JOINTS
        look = {"label": joints[joint], "lw": 0.8} if named else {"color": "0.8", "lw": 0.5}
        axes.plot(log.fields["time"], tau[:, joint], zorder=2 if named else 1, **look)
    axes.set_ylabel("torque [N m]" if outline is None else "torque / limit")
    axes.legend(loc="upper right", fontsize="small", ncols=3)


def _draw_forces(log: Log, axes: Any) -> None:
    wrenches = log.fields["wrenches"]
    count = wrenches.shape[1] // 6
    outline = log.outline
    names = [str(each) for each in range(count)] if outline is None else outline.known.contacts
    for number, name in zip(range(count), names, strict=True):
        axes.plot(log.fields["time"], wrenches[:, 6 * number + 2], lw=0.8, label=name)
    axes.set_ylabel("planned normal force [N]")
    axes.legend(loc="upper right", fontsize="small")


def _shade_measured(log: Log, axes: Any) -> None:
    times = log.fields["time"][log.fields["measured"]]
    if times.size:
        axes.axvspan(times[0], times[-1], color="0.93", zorder=0)


def _title(log: Log) -> str:
    if log.outline is None:
        return log.robot or "log"
    parameters = "".join(f" {name} {value:g}" for name, value in log.outline.parameters.items())
    return f"{log.robot}: {log.outline.motion}{parameters} (shaded: the laps that are measured)"
