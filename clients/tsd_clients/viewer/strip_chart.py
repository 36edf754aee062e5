"""A strip chart: the last seconds of some quantities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import viser
from viser import uplot

from tsd_casadi.state import Vector

# points over the width of a chart: more than pixels would be none
POINTS = 300
EMPTY = np.array([0.0, 1.0])


@dataclass(frozen=True)
class Line:
    """One line of a chart.

    Attributes:
        name: In the legend.
        color: CSS.
        width: [pixels].
    """

    name: str
    color: str
    width: float = 1.8


class StripChart:
    """Lines over time."""

    def __init__(
        self, gui: viser.GuiApi, title: str, lines: Sequence[Line], *, height: int = 150
    ) -> None:
        """Add the chart.

        Args:
            title: With the unit.
            height: [pixels].
        """
        nothing = np.full(len(EMPTY), np.nan)
        self._chart = gui.add_uplot(
            data=(EMPTY, *(nothing for _ in lines)),
            series=(
                uplot.Series(label="t [s]"),
                *(
                    uplot.Series(label=line.name, stroke=line.color, width=line.width)
                    for line in lines
                ),
            ),
            scales={"x": uplot.Scale(time=False)},
            axes=(uplot.Axis(size=34), uplot.Axis(size=52)),
            title=title,
            height=height,
        )

    def show(self, time: Vector, values: Sequence[Vector]) -> None:
        """Draw the lines anew.

        Args:
            time: (T,) [s].
            values: One line each, (T,).
        """
        if len(time) < 2:
            return
        step = -(-len(time) // POINTS)
        # counted from the end: lines that move do not flicker
        cut = slice((len(time) - 1) % step, None, step)
        self._chart.data = tuple(np.array(each[cut], dtype=float) for each in (time, *values))

    def remove(self) -> None:
        """Take it away."""
        self._chart.remove()
