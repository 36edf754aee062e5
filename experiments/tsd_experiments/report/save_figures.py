"""The figures of a report as files."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

from matplotlib import pyplot as plt

from tsd_experiments.harness.section import Section


def save_figures(sections: Sequence[Section], folder: Path) -> dict[str, bytes]:
    """Draw every figure as PNG and SVG.

    Returns:
        The PNG of each by name.
    """
    folder.mkdir(parents=True, exist_ok=True)
    pictures = {}
    for section in sections:
        for figure in section.figures:
            drawn = figure.draw()
            buffer = io.BytesIO()
            drawn.savefig(buffer, dpi=110, format="png")
            drawn.savefig(folder / f"{figure.name}.svg")
            plt.close(drawn)
            pictures[figure.name] = buffer.getvalue()
            (folder / f"{figure.name}.png").write_bytes(pictures[figure.name])
    return pictures
