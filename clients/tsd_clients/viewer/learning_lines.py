"""Lines of what was learned: errors by iteration, weights before and after, harmonics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.state import Vector
from tsd_casadi.wire.telemetry import IterationRecorded
from tsd_clients.viewer.learning_story import ErrorHistory, change_of, shares_of
from tsd_clients.viewer.line_chart import COLORS, Line, Shade
from tsd_clients.viewer.prediction import LearnedCurve

EPOCH = "#c92a2a"
# half of the width of an upright line, in iterations: less than a pixel
UPRIGHT = 1e-3


def error_chart(
    histories: dict[str, ErrorHistory],
) -> tuple[Vector, list[Line], list[Shade]]:
    """Make x, lines and shades of errors along axes of one unit, in thousandths of it.

    Each epoch has lines of its own; an upright one stands where the robot changed.
    """
    first = next(iter(histories.values()))
    # two points that are next to one another
    edges = [cut + side for cut in first.epochs_begin for side in (-UPRIGHT, UPRIGHT)]
    x = np.sort(np.concatenate([first.number, edges]))
    lines, shades = [], []
    for (axis, history), color in zip(histories.items(), COLORS, strict=False):
        for epoch in np.unique(history.epoch):
            place = _Place(x, history.number, history.epoch == epoch)
            name = axis if epoch == history.epoch.min() else f"{axis}, epoch {epoch:.0f}"
            if history.has_deviation:
                low, high = map(place, history.repeatability)
                shades.append(Shade(low, high, color))
            lines.append(Line(name, place(history.rms), color, points=True))
            if history.true_differs:
                true = place(history.true_rms)
                lines.append(Line(f"{name}, true", true, color, dash=(4.0, 4.0)))
    every = np.concatenate([line.values for line in lines])
    for cut in first.epochs_begin:
        mark = np.full(len(x), np.nan)
        mark[np.abs(x - cut) < 2 * UPRIGHT] = np.nanmin(every), np.nanmax(every)
        lines.append(Line("the robot changed", mark, EPOCH, width=2.0))
    return x, lines, shades


@dataclass(frozen=True)
class _Place:
    """Puts values of iterations where they belong on x, in thousandths."""

    x: Vector
    number: Vector
    chosen: NDArray[np.bool_]

    def __call__(self, values: Vector) -> Vector:
        out = np.full(len(self.x), np.nan)
        out[np.searchsorted(self.x, self.number[self.chosen])] = 1e3 * values[self.chosen]
        return out


def weight_lines(
    axis: str, recorded: IterationRecorded | None, curve: LearnedCurve | None
) -> list[Line]:
    """Make the lines of what is fed forward along an axis; none where nobody knows."""
    if recorded is not None and axis in recorded.axes:
        change = change_of(recorded, axis)
        return [
            Line(
                f"before, iteration {recorded.iteration}", change.before, COLORS[4], dash=(6.0, 4.0)
            ),
            Line(f"after, iteration {recorded.served}", change.after, COLORS[0], width=2.5),
        ]
    if curve is not None and axis in curve.feedforward.axes:
        label = f"iteration {curve.feedforward.iteration}, served"
        return [Line(label, curve.over_phase(axis), COLORS[0], width=2.5)]
    return []


def share_lines(axis: str, recorded: IterationRecorded | None) -> list[Line]:
    """Make the lines of what an iteration leaves of each harmonic; none where nobody knows."""
    contractions = () if recorded is None else recorded.contractions
    return [
        Line(name, values, color, points=True)
        for each in contractions
        if each.axis == axis
        for (name, values), color in zip(shares_of(each).items(), COLORS, strict=False)
        if np.isfinite(values).any()
    ]
