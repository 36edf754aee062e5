"""A squat, a sway and a circle: how they look, and where the centre of mass goes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib import pyplot as plt

from tsd_casadi.state import Vector
from tsd_clients.viewer.rendering import side_by_side
from tsd_experiments.harness.job import Result
from tsd_experiments.report.curve import STYLES
from tsd_experiments.report.drawing import finish, name_of

RUNS = {"none": ("no feedforward", "iteration 0"), "learned": ("2 iterations", "iteration 2")}


def draw_motions(results: Mapping[str, Result], stills: Callable[[Result], Any]) -> Any:
    """Draw one column per motion: pictures above, the last lap of the moved axes below.

    Args:
        results: Learned by all axes, by name of the motion.
        stills: Renders the extremes of one, or gives None.
    """
    frames = {motion: stills(result) for motion, result in results.items()}
    pictured = all(frame is not None for frame in frames.values())
    figure, panels = plt.subplots(
        1 + pictured, len(results), figsize=(10, 3.4 + 3.2 * pictured), squeeze=False
    )
    for column, (motion, result) in enumerate(results.items()):
        if pictured:
            panels[0, column].imshow(side_by_side(frames[motion]))
            panels[0, column].axis("off")
        panels[0, column].set_title(motion)
        _draw_lap(panels[-1, column], result)
    panels[-1, 0].legend(fontsize=8)
    return finish(figure)


def _draw_lap(axes: Any, result: Result) -> None:
    """Draw where the moved axes go: two against each other, or one over the phase."""
    names = result.rows[0]["axes"]
    moved = [name for name in names if np.ptp(_trace(result, "iteration 0", "reference", name)) > 0]
    for style, (legend, label) in RUNS.items():
        places = [1e3 * _place(result, label, axis) for axis in moved]
        if len(moved) == 1:
            places.insert(0, _trace(result, label, "phase", names[0])[_last(result, label)])
            places[0] = (places[0] - places[0][0]) / (2 * np.pi)
        axes.plot(*places, label=legend, **STYLES[style])
    label = "iteration 0"
    wanted = [
        1e3 * _trace(result, label, "reference", axis)[_last(result, label)] for axis in moved
    ]
    if len(moved) == 1:
        wanted.insert(0, np.linspace(0, 1, len(wanted[0])))
        axes.set(xlabel="part of the lap", ylabel=f"{name_of(moved[0])} [mm]")
    else:
        axes.set(xlabel=f"{name_of(moved[0])} [mm]", ylabel=f"{name_of(moved[1])} [mm]")
        axes.set_aspect("equal")
    axes.plot(*wanted, label="reference", **STYLES["reference"])
    axes.grid(alpha=0.3)


def _trace(result: Result, label: str, name: str, axis: str) -> Vector:
    first = result.rows[0]["axes"][0] == axis
    return result.arrays[f"{label}/{name}" if first else f"{label}/{name}/{axis}"]


def _last(result: Result, label: str) -> Vector:
    lap = result.arrays[f"{label}/lap"]
    return np.asarray(lap == lap.max())


def _place(result: Result, label: str, axis: str) -> Vector:
    last = _last(result, label)
    return np.asarray(
        (_trace(result, label, "reference", axis) - _trace(result, label, "error", axis))[last]
    )
