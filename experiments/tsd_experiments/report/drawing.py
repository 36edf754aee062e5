"""Figures in the paper's layout, from the signals of runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np

from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.state import Vector
from tsd_experiments.report.curve import STYLES, Curve

matplotlib.use("Agg")

from matplotlib import pyplot as plt

MOST_MARKERS = 50
COLORS = ("#3b6fb6", "#c8352b", "#d99a1c", "#2f7d4f", "#6b3fa0", "#777777", "#20a0b0", "#a05030")


def name_of(axis: str) -> str:
    """Name an axis 'task.axis' for a figure: 'CoM z', 'torso rz'."""
    task, _, component = axis.rpartition(".")
    return f"{'CoM' if task == 'com' else task} {component}"


def draw_tracking(curves: Sequence[Curve], title: str) -> Any:
    """Draw position, error, and the error close up (cog_err and gen_cog_err of the paper).

    Where joints met their limits a last panel says which ones, and when.

    Args:
        curves: The first one is left out of the close view.
    """
    limits = sorted({row for curve in curves for row in curve.limited})
    height = 0.5 + 0.25 * len(limits)
    heights = (2.2, 2.2, 2.2, height) if limits else (2.2, 2.2, 2.2)
    figure, (top, middle, bottom, *last) = plt.subplots(
        len(heights), 1, figsize=(8, 0.4 + sum(heights)), sharex=True, height_ratios=heights
    )
    for axes in last:
        _mark_limits(axes, curves, limits)
    for curve in curves:
        style, signals = STYLES[curve.style], curve.signals
        time, error = signals["time"], signals["error"]
        top.plot(time, signals["reference"] - error, label=curve.legend, **style)
        for axes in (middle, bottom):
            axes.plot(time, 1e3 * error, **style)
    first = curves[0].signals
    top.plot(first["time"], first["reference"], label="reference", **STYLES["reference"])
    start = float(first["time"][np.argmax(first["lap"] >= 0)])
    for axes in (top, middle, bottom, *last):
        axes.axvline(start, color="black", linestyle=":", linewidth=1)
        axes.grid(alpha=0.3)
    unit = unit_of_axis(curves[0].axis)
    low, high = top.get_ylim()
    top.set_ylim(low, high + 0.25 * (high - low))  # room for the legend
    top.legend(loc="upper center", fontsize=8, ncols=4)
    top.set(ylabel=f"{name_of(curves[0].axis)} about its middle [{unit}]", title=title)
    middle.set_ylabel(f"error [m{unit}]")
    bound = 2e3 * max(curve.peak_error or 0.0 for curve in curves[1:])
    bottom.set(ylabel=f"error, close [m{unit}]", ylim=(-bound, bound))
    (last or [bottom])[-1].set_xlabel("time [s]")
    return finish(figure)


def _mark_limits(axes: Any, curves: Sequence[Curve], limits: Sequence[str]) -> None:
    """Draw a bar wherever a joint was at or past a limit, a line of bars for each limit."""
    share = 0.8 / len(curves)
    for place, curve in enumerate(curves):
        time, color = curve.signals["time"], STYLES[curve.style]["color"]
        for line, row in enumerate(limits):
            if row in curve.limited:
                low = line - 0.4 + place * share
                when = curve.limited[row].astype(bool)
                axes.fill_between(
                    time, low, low + share, where=when, step="post", color=color, linewidth=0.5
                )
    axes.set_yticks(range(len(limits)), limits, fontsize=7)
    axes.set_ylim(len(limits) - 0.5, -0.5)


def draw_errors(panels: Sequence[tuple[str, Sequence[Curve]]], shared: bool = True) -> Any:
    """Draw errors over time, one panel below the other (realcog_err of the paper).

    Args:
        panels: Heading and curves of each.
        shared: Give all panels the same time axis.
    """
    figure, axes = plt.subplots(
        len(panels), 1, figsize=(8, 2.6 * len(panels)), sharex=shared, squeeze=False
    )
    for panel, (title, curves) in zip(axes[:, 0], panels, strict=True):
        for curve in curves:
            time, error = curve.signals["time"], curve.signals["error"]
            panel.plot(time, 1e3 * error, label=curve.legend, **STYLES[curve.style])
        panel.set(title=title, ylabel=f"error [m{unit_of_axis(curves[0].axis)}]")
        panel.legend(fontsize=8, ncols=3)
        panel.grid(alpha=0.3)
    axes[-1, 0].set_xlabel("time [s]")
    return finish(figure)


def draw_feedback(curves: Sequence[Curve], encoded: Curve) -> Any:
    """Draw feedback and, over it, the encoded feedforward (RBS_error of the paper).

    Args:
        encoded: The run whose feedforward is drawn.
    """
    figure, axes = plt.subplots(figsize=(8, 3.5))
    for curve in curves:
        time, feedback = curve.signals["time"], curve.signals["feedback"]
        axes.plot(time, feedback, label=curve.legend, **STYLES[curve.style])
    time, feedforward = encoded.signals["time"], encoded.signals["feedforward"]
    axes.plot(time, feedforward, label="encoded feedforward", **STYLES["encoded"])
    # the first moments of a run, from rest, would dwarf the rest
    bound = 1.6 * float(np.max(np.abs(feedforward)))
    axis = encoded.axis
    ylabel = f"feedback, {name_of(axis)} [{unit_of_axis(axis)}/s²]"
    axes.set(xlabel="time [s]", ylabel=ylabel, ylim=(-bound, bound / 2))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, ncols=2)
    return finish(figure)


def draw_lines(
    lines: Sequence[tuple[str, Sequence[float] | Vector, Sequence[float] | Vector]],
    xlabel: str,
    ylabel: str,
    *,
    logx: bool = False,
    logy: bool = True,
    turn: int = len(COLORS),
) -> Any:
    """Draw lines, with markers where there is room for them.

    Args:
        lines: Legend, x and y of each.
        turn: After so many lines the colours begin again, dashed.
    """
    figure, axes = plt.subplots(figsize=(8, 4))
    for index, (legend, x, y) in enumerate(lines):
        color = COLORS[index % turn]
        style = "-" if index < turn else "--"
        marker = "o" if len(x) <= MOST_MARKERS else ""
        axes.plot(x, y, marker=marker, linestyle=style, color=color, label=legend, markersize=4)
    axes.set(xlabel=xlabel, ylabel=ylabel)
    if logx:
        axes.set_xscale("log")
    if logy:
        axes.set_yscale("log")
    axes.grid(alpha=0.3, which="both")
    axes.legend(fontsize=8, ncols=2)
    return finish(figure)


def draw_bands(
    x: Vector, bands: Sequence[tuple[str, Vector, Vector, Vector]], xlabel: str, ylabel: str
) -> Any:
    """Draw predictions and what came out; below, the difference and two standard deviations.

    Args:
        x: The x axis, (N,).
        bands: Legend, mean, standard deviation and outcome of each, (N,).
    """
    figure, panels = plt.subplots(
        1 + len(bands),
        1,
        figsize=(8, 3.2 + 1.3 * len(bands)),
        sharex=True,
        height_ratios=[2.4, *(1.0 for _ in bands)],
    )
    top, *below = panels
    for axes, color, (legend, mean, std, outcome) in zip(below, COLORS, bands, strict=False):
        top.plot(x, mean, color=color, label=legend)
        top.plot(x, outcome, "--", color=color)
        axes.fill_between(x, -2 * std, 2 * std, color=color, alpha=0.25)
        axes.plot(x, outcome - mean, "--", color=color)
        axes.set_ylabel("off by\n[m/s²]")
    for axes in panels:
        axes.grid(alpha=0.3)
    top.set_ylabel(ylabel)
    top.legend(fontsize=8)
    panels[-1].set_xlabel(xlabel)
    return finish(figure)


def finish(figure: Any) -> Any:
    """Set the margins of a figure."""
    figure.tight_layout()
    return figure
