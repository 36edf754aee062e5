"""The figure of what the pushes do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib import pyplot as plt

from tsd_experiments.beyond.stiffness_or_feedforward.tables import IMPULSE, PUSHES, words_for
from tsd_experiments.harness.job import Result
from tsd_experiments.report.drawing import COLORS, finish


def draw_deflections(disturbed: Mapping[str, Mapping[str, Result]]) -> Any:
    """Draw the deflection along each push, one row per world.

    Args:
        disturbed: What ``disturb`` left behind, by world and contender.
    """
    figure, panels = plt.subplots(
        len(disturbed), len(PUSHES), figsize=(9, 3 * len(disturbed)), squeeze=False
    )
    for row, (world, results) in zip(panels, disturbed.items(), strict=True):
        for axes, (push, impulse) in zip(row, PUSHES.items(), strict=True):
            direction = np.array(impulse) / IMPULSE
            for color, (name, result) in zip(COLORS, results.items(), strict=False):
                along = result.arrays[f"{push}/deflection"] @ direction
                time = result.arrays[f"{push}/time"]
                axes.plot(time, 1e3 * along, color=color, label=words_for(name))
            axes.set(title=f"{world}, {push}", xlabel="time since the push [s]", xlim=(0, 3))
            axes.grid(alpha=0.3)
        row[0].set_ylabel("deflection [mm]")
    panels[0, 0].legend(fontsize=8)
    return finish(figure)
