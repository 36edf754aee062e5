"""A squat, a sway and a circle: how they look, and where the centre of mass goes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import pyplot as plt

from tsd_casadi.robot.robot import load_robot
from tsd_casadi.state import Vector
from tsd_clients.film.rendering import render_postures, side_by_side
from tsd_experiments.beyond.any_motion.measures import measure_of
from tsd_experiments.harness.job import Result
from tsd_experiments.report.curve import STYLES
from tsd_experiments.report.drawing import COLORS, finish, name_of

RUNS = {"none": ("no feedforward", "iteration 0"), "learned": ("2 iterations", "iteration 2")}


def draw_motions(results: Mapping[str, Result], stills: Callable[[str, Result], Any]) -> Any:
    """Draw one column per motion: pictures, the last lap of the moved axes, errors.

    Args:
        results: Learned along all axes, by name of the motion.
        stills: Renders the extremes of one, or gives None.
    """
    frames = {motion: stills(motion, result) for motion, result in results.items()}
    pictured = all(frame is not None for frame in frames.values())
    figure, panels = plt.subplots(
        2 + pictured, len(results), figsize=(10, 5.6 + 2.6 * pictured), squeeze=False
    )
    for column, (motion, result) in enumerate(results.items()):
        if pictured:
            panels[0, column].imshow(side_by_side(frames[motion]))
            panels[0, column].axis("off")
        panels[0, column].set_title(motion)
        _draw_lap(panels[-2, column], result)
        _draw_errors(panels[-1, column], result)
    for row in (-2, -1):
        panels[row, 0].legend(fontsize=8)
    return finish(figure)


def render_stills(motion: str, result: Result) -> Any:
    """Render the extremes of a motion; None where nothing can be rendered."""
    robot_file = Path(result.rows[0].get("robot_file", ""))
    if not robot_file.is_file():
        return None
    # sideways motions from in front
    azimuth = None if motion == "squat" else 165.0
    return render_postures(load_robot(robot_file), result.arrays["extremes"], 240, 320, azimuth)


def _draw_lap(axes: Any, result: Result) -> None:
    """Draw where the moved axes go: two against each other, or one over the lap."""
    names = result.rows[0]["axes"]
    moved = [name for name in names if np.ptp(_trace(result, "iteration 0", "reference", name)) > 0]
    for style, (legend, label) in RUNS.items():
        lap = _last(result, label)
        wanted = [1e3 * _trace(result, label, "reference", axis)[lap] for axis in moved]
        errors = [1e3 * _trace(result, label, "error", axis)[lap] for axis in moved]
        part = [np.linspace(0, 1, len(wanted[0]))] if len(moved) == 1 else []
        places = [x - e for x, e in zip(wanted, errors, strict=True)]
        axes.plot(*part, *places, label=legend, **STYLES[style])
    axes.plot(*part, *wanted, label="reference", **STYLES["reference"])
    labels = [f"{name_of(axis)} [mm]" for axis in moved]
    across, up = labels if len(moved) == 2 else ("part of the lap", *labels)
    axes.set(xlabel=across, ylabel=up)
    if len(moved) == 2:
        axes.set_aspect("equal", adjustable="datalim")
    axes.grid(alpha=0.3)


def _draw_errors(axes: Any, result: Result) -> None:
    """Draw the RMS error of every learned axis by iteration."""
    for color, axis in zip(COLORS, sorted(result.rows[0]["axes"]), strict=False):
        errors = [1e3 * measure_of(row, axis) for row in result.rows]
        axes.plot(range(len(errors)), errors, "o-", color=color, label=name_of(axis), markersize=4)
    axes.set(xlabel="iterations", ylabel="RMS error [mm]", yscale="log")
    axes.set_xticks(range(len(result.rows)))
    axes.grid(alpha=0.3)


def _trace(result: Result, label: str, name: str, axis: str) -> Vector:
    first = result.rows[0]["axes"][0] == axis
    return result.arrays[f"{label}/{name}" if first else f"{label}/{name}/{axis}"]


def _last(result: Result, label: str) -> Vector:
    lap = result.arrays[f"{label}/lap"]
    return np.asarray(lap == lap.max())
