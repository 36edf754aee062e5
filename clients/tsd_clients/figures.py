"""Figures of a demonstration, after the paper's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

from tsd_clients.run import Run

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


def draw_figures(runs: dict[str, Run], out: Path) -> list[Path]:
    """Draw position and error, feedback, and generalisation.

    Args:
        runs: The runs by their labels in the demonstration.
        out: Folder.

    Returns:
        The files, PNG.
    """
    one = {
        "no feedforward": (runs["3 cm, none"], "none"),
        "learned, 1 iteration": (runs["3 cm, learned, iteration 1"], "learned"),
        "learned, P / 5": (runs["3 cm, P/5, learned, iteration 1"], "reduced"),
    }
    other = {
        "no feedforward": (runs["5 cm, none"], "none"),
        "learned, 2 iterations": (runs["5 cm, learned, iteration 2"], "learned"),
        "generalised": (runs["5 cm, generalised"], "reduced"),
    }
    return [
        _draw_tracking(one, out / "com_error.png", "3 cm squat, 10 % wrong model"),
        _draw_feedback(one, out / "feedback.png"),
        _draw_tracking(other, out / "generalisation.png", "5 cm squat from 2, 4, 6 and 8 cm"),
    ]


def _draw_tracking(runs: dict[str, tuple[Run, str]], path: Path, title: str) -> Path:
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
    learned = [run for label, (run, _) in runs.items() if label != "no feedforward"]
    bound = max(1e3 * run.peak_error for run in learned)
    bottom.set_ylim(-2 * bound, 2 * bound)
    bottom.set_ylabel("error, close [mm]")
    bottom.set_xlabel("time [s]")
    return _save(figure, path)


def _draw_feedback(runs: dict[str, tuple[Run, str]], path: Path) -> Path:
    figure, axes = plt.subplots(figsize=(8, 3.5))
    for label, (run, style) in runs.items():
        axes.plot(run.log["time"], run.log["feedback"], label=label, **STYLES[style])
    learned = runs["learned, 1 iteration"][0]
    axes.plot(
        learned.log["time"],
        learned.log["feedforward"],
        label="encoded feedforward",
        **STYLES["encoded"],
    )
    axes.set_ylabel("feedback [m/s²]")
    axes.set_xlabel("time [s]")
    axes.set_ylim(-1.2, 0.4)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, ncols=2)
    return _save(figure, path)


def _save(figure: Any, path: Path) -> Path:
    figure.tight_layout()
    figure.savefig(path, dpi=130)
    plt.close(figure)
    return path
