"""Error, feedback and feedforward beside the robot, growing with time.

The charts are drawn twice, empty and full; a picture of the film is the full one on
the left of now and the empty one on its right, which takes no time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.state import Matrix, Vector
from tsd_clients.film.clip import SIGNALS, Clip
from tsd_clients.film.video_file import Picture

DPI = 100.0
COLORS = ("#3b6fb6", "#c8352b", "#2f7d4f", "#d99a1c", "#6b3fa0", "#20a0b0", "#a05030", "#777777")
SMALL, TEXT = 6.5, 7.5  # points
# of the height of a chart, above and below what is drawn
MARGIN = 0.12
# what is flat is drawn as flat and not as its rounding: half the least height of a chart
# [mm or mrad; m/s^2 or rad/s^2]
FLAT = {"error": 0.1, "feedback": 0.05, "feedforward": 0.05}
NOW = (40, 40, 40)


class StripCharts:
    """The charts of some clips one after another."""

    def __init__(self, clips: Sequence[Clip], width: int, height: int) -> None:
        """Draw them.

        Args:
            clips: With the same axes and rate.
            width: [pixels].
            height: [pixels].
        """
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, layout="constrained")
        canvas = FigureCanvasAgg(figure)
        charts: Any = figure.subplots(len(SIGNALS), 1, sharex=True)
        lines = [
            line
            for chart, name in zip(charts, SIGNALS, strict=True)
            for line in _draw(chart, name, clips)
        ]
        _name_times(charts[-1], clips)
        if len(clips[0].axes) > 1:
            figure.legend(
                *charts[0].get_legend_handles_labels(),
                loc="outside upper left",
                fontsize=SMALL,
                ncols=3,
                frameon=False,
                handlelength=1.2,
            )
        self._full = _picture(canvas)
        figure.set_layout_engine("none")  # the places stay
        for line in lines:
            line.set_visible(False)
        self._empty = _picture(canvas)
        boxes = [chart.get_window_extent() for chart in charts]
        self._left, self._right = boxes[0].x0, boxes[0].x1
        self._rows = [slice(int(height - box.y1), int(height - box.y0)) for box in boxes]
        self._seconds = sum(clip.seconds for clip in clips)

    def at(self, time: float) -> Picture:
        """Give the charts up to a time of the film [s], (height, width, 3)."""
        share = min(max(time / self._seconds, 0.0), 1.0)
        now = round(self._left + share * (self._right - self._left))
        picture = self._empty.copy()
        picture[:, :now] = self._full[:, :now]
        for rows in self._rows:
            picture[rows, now] = NOW
        return picture


def _draw(chart: Any, name: str, clips: Sequence[Clip]) -> list[Any]:
    """Draw one signal of all clips; gives the lines that grow."""
    is_error = name == "error"
    factor = 1e3 if is_error else 1.0
    axes = clips[0].axes
    starts = np.cumsum([0.0, *(clip.seconds for clip in clips)])
    time, values = _joined(clips, starts, name)
    lines = [
        chart.plot(time, factor * column, color=color, linewidth=1.4, label=axis)[0]
        for axis, column, color in zip(axes, values.T, _colors(len(axes)), strict=True)
    ]
    chart.axhline(0.0, color="#999999", linewidth=0.6, zorder=0)
    for start in starts[1:-1]:
        chart.axvline(start, color="#999999", linewidth=0.8, zorder=0)
    low, high = _limits(factor * values, FLAT[name])
    chart.set(xlim=(0.0, starts[-1]), ylim=(low, high))
    chart.set_title(f"{name} [{_unit(axes, is_error)}]", fontsize=TEXT, loc="right", pad=3)
    chart.tick_params(labelsize=SMALL, length=2)
    chart.grid(alpha=0.3, linewidth=0.5, axis="y" if len(clips) > 1 else "both")
    return lines


def _name_times(chart: Any, clips: Sequence[Clip]) -> None:
    """Write below which clip it is, where there are several, and the time else."""
    if len(clips) == 1:
        chart.set_xlabel("time [s]", fontsize=TEXT)
        return
    seconds = np.array([clip.seconds for clip in clips])
    chart.set_xticks(np.cumsum(seconds) - 0.5 * seconds, [clip.label for clip in clips])
    for each in chart.figure.axes:
        each.tick_params(axis="x", length=0)


def _joined(clips: Sequence[Clip], starts: Vector, name: str) -> tuple[Vector, Matrix]:
    """Put clips one after another, with nothing between them."""
    times, values = [], []
    for start, clip in zip(starts, clips, strict=False):
        own = clip.signals[name]
        times += [start + np.arange(len(own)) / clip.rate, [start + clip.seconds]]
        values += [own, np.full((1, own.shape[1]), np.nan)]
    return np.concatenate(times), np.concatenate(values)


def _limits(values: Matrix, flat: float) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    low, high = (known.min(), known.max()) if len(known) else (0.0, 0.0)
    low, high = min(low, -flat), max(high, flat)
    margin = MARGIN * (high - low)
    return low - margin, high + margin


def _colors(count: int) -> list[str]:
    return [COLORS[place % len(COLORS)] for place in range(count)]


def _unit(axes: Sequence[str], is_error: bool) -> str:
    units = sorted({unit_of_axis(axis) for axis in axes})
    return ", ".join(f"m{unit}" if is_error else f"{unit}/s²" for unit in units)


def _picture(canvas: Any) -> Picture:
    canvas.draw()
    return np.array(canvas.buffer_rgba())[:, :, :3]
