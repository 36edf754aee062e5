"""Figures of a demonstration, after the paper's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

from tsd_casadi.repetition.run import Run

matplotlib.use("Agg")

from matplotlib import pyplot as plt

# distinct in colour and in grey
STYLES: dict[str, dict[str, Any]] = {
    "none": {"color": "#3b6fb6", "linestyle": "-"},
    "learned": {"color": "#c8352b", "linestyle": "-"},
    "reduced": {"color": "#d99a1c", "linestyle": "-"},
    "reference": {"color": "#2f7d4f", "linestyle": "--"},
    "encoded": {"color": "#6b3fa0", "linestyle": "--"},
}


def draw_tracking(runs: dict[str, tuple[Run, str]], title: str, path: Path) -> None:
    """Draw position and error of some runs (the paper's cog_err and gen_cog_err).

    Args:
        runs: Run and style by legend entry; the first one is without feedforward
            and left out of the closest view.
    """
    figure, (top, middle, bottom) = plt.subplots(3, 1, figsize=(8, 7), sharex=True)
    for label, (run, style) in runs.items():
        time, error = run.log["time"], run.log["error"]
        top.plot(time, run.log["reference"] - error, label=label, **STYLES[style])
        for axes in (middle, bottom):
            axes.plot(time, 1e3 * error, **STYLES[style])
    first = next(iter(runs.values()))[0]
    top.plot(first.log["time"], first.log["reference"], label="reference", **STYLES["reference"])
    start = float(first.log["time"][np.argmax(first.log["lap"] >= 0)])
    for axes in (top, middle, bottom):
        axes.axvline(start, color="black", linestyle=":", linewidth=1)
        axes.grid(alpha=0.3)
    top.set_ylabel("CoM z [m]")
    top.set_title(title)
    top.legend(loc="upper center", fontsize=8, ncols=4)
    low, high = top.get_ylim()
    top.set_ylim(low, high + 0.2 * (high - low))  # room for the legend
    middle.set_ylabel("error [mm]")
    bound = max(1e3 * run.peak_error for run, _ in list(runs.values())[1:])
    bottom.set_ylim(-2 * bound, 2 * bound)
    bottom.set_ylabel("error, close [mm]")
    bottom.set_xlabel("time [s]")
    _save(figure, path)


def draw_feedback(runs: dict[str, tuple[Run, str]], encoded: Run, path: Path) -> None:
    """Draw the feedback term of some runs (the paper's RBS_error).

    Args:
        runs: Run and style by legend entry.
    """
    figure, axes = plt.subplots(figsize=(8, 3.5))
    for label, (run, style) in runs.items():
        axes.plot(run.log["time"], run.log["feedback"], label=label, **STYLES[style])
    axes.plot(
        encoded.log["time"],
        encoded.log["feedforward"],
        label="encoded feedforward",
        **STYLES["encoded"],
    )
    axes.set_ylabel("feedback [m/s²]")
    axes.set_xlabel("time [s]")
    # the first moments of a run, from rest, would dwarf the rest
    bound = 1.6 * float(np.max(np.abs(encoded.log["feedforward"])))
    axes.set_ylim(-bound, bound / 2)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, ncols=2)
    _save(figure, path)


def _save(figure: Any, path: Path) -> None:
    figure.tight_layout()
    figure.savefig(path, dpi=130)
    plt.close(figure)
