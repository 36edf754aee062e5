"""A chart of some lines with shades around them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import viser
import viser.uplot

from tsd_casadi.state import Vector

# next to one another told apart by people who see colours differently (Okabe and Ito, 2008)
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
QUARTERS = tuple(np.linspace(0.0, 2 * np.pi, 5).tolist())
QUARTER_NAMES = ("0", "π/2", "π", "3π/2", "2π")
# above, right, below, left of a chart: room for half of the highest number [pixels]
PADDING = (12, 24, 0, 0)
# of the range of y, beyond the values
MARGIN = 0.05
# whole numbers only
COUNTS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
# edges of shades are no lines that a legend should name; each panel with charts adds this
HIDDEN = "tsd-hidden"
STYLE = f"<style>.{HIDDEN} {{ display: none; }}</style>"
HEIGHT = 210  # pixels: two of them beside some sliders on a small screen


@dataclass(frozen=True)
class Line:
    """A line.

    Attributes:
        label: In the legend.
        values: Over the chart's x; NaN where there is none, by which a line is not
            interrupted.
        color: Of it.
        width: Of it [pixels].
        dash: Lengths of dashes and of what is between them [pixels]; empty for none.
        points: Whether each value has a dot.
    """

    label: str
    values: Vector
    color: str
    width: float = 1.5
    dash: tuple[float, ...] = ()
    points: bool = False

    def series(self) -> viser.uplot.Series:
        """Say how it is drawn."""
        series = viser.uplot.Series(
            label=self.label,
            stroke=self.color,
            width=self.width,
            points=viser.uplot.Series_Points(show=self.points, size=7.0, fill=self.color),
        )
        if self.dash:
            series["dash"] = self.dash
        return series


@dataclass(frozen=True)
class Shade:
    """What lies between two lines that are not drawn.

    Attributes:
        low: Over the chart's x.
        high: Over the chart's x.
        color: '#rrggbb'.
        opacity: 0 to 1.
    """

    low: Vector
    high: Vector
    color: str
    opacity: float = 0.2


class LineChart:
    """A chart whose lines may change with what is shown."""

    def __init__(
        self,
        gui: viser.GuiApi,
        title: str,
        x_label: str,
        y_label: str,
        *,
        over_phase: bool = False,
        counted: bool = False,
        logarithmic: bool = False,
        height: int = HEIGHT,
    ) -> None:
        """Add it to the page.

        Args:
            y_label: With a unit.
            over_phase: Whether x is a phase, from 0 to 2 pi.
            counted: Whether x are whole numbers.
            logarithmic: Whether y is; values have to be positive.
            height: [pixels].
        """
        x_axis = viser.uplot.Axis(label=x_label, labelSize=18.0, size=32.0)
        x_scale = viser.uplot.Scale(time=False)
        if over_phase:
            x_axis["splits"], x_axis["values"] = QUARTERS, QUARTER_NAMES
            x_scale["range"] = (0.0, 2 * np.pi)
        if counted:
            x_axis["incrs"] = COUNTS
        y_scale = viser.uplot.Scale(distr=3, log=10) if logarithmic else viser.uplot.Scale()
        y_axis = viser.uplot.Axis(label=y_label, labelSize=18.0, size=56.0)
        self._scales: dict[str, viser.uplot.Scale] = {"x": x_scale, "y": y_scale}
        self._axes = x_axis, y_axis
        self._logarithmic = logarithmic
        nothing = np.array([1.0, 1.0])
        self._chart = gui.add_uplot(
            (np.array([0.0, 1.0]), nothing),
            (viser.uplot.Series(label=x_label), viser.uplot.Series(label="")),
            title=title,
            scales=self._scales,
            axes=self._axes,
            cursor=viser.uplot.Cursor(drag=viser.uplot.Cursor_Drag(x=False, y=False)),
            height=height,
            padding=PADDING,
        )
        self._x_name = x_label.partition(" [")[0]
        self._series: list[viser.uplot.Series] = []

    def show(self, x: Vector, lines: Sequence[Line], shades: Sequence[Shade] = ()) -> None:
        """Draw other lines, shades behind them.

        Args:
            x: Of all lines and shades, ascending.
            lines: At least one.
        """
        edges = [edge for shade in shades for edge in (shade.low, shade.high)]
        data = (x, *edges, *(line.values for line in lines))
        series = [viser.uplot.Series(label=self._x_name)]
        for shade in shades:
            edge = viser.uplot.Series(
                stroke=_transparent(shade), width=0.5, points=viser.uplot.Series_Points(show=False)
            )
            series += [{**edge, "class": HIDDEN}] * 2
        series += [line.series() for line in lines]
        if series != self._series:
            self._series = series
            self._chart.series = tuple(series)
            self._chart.bands = tuple(
                viser.uplot.Band(series=(2.0 * i + 2, 2.0 * i + 1), fill=_transparent(shade))
                for i, shade in enumerate(shades)
            )
        values = np.concatenate(data[1:])
        finite = values[np.isfinite(values)]
        if finite.size and (self._logarithmic or finite.size < values.size):
            self._set_range(finite)
        self._chart.data = tuple(np.asarray(each, dtype=float) for each in data)

    def _set_range(self, values: Vector) -> None:
        """Choose the range of y: uPlot finds none where a value is missing."""
        low, high = float(values.min()), float(values.max())
        if self._logarithmic:
            first = np.floor(np.log10(low))
            powers = np.arange(first, max(np.ceil(np.log10(high)), first + 1) + 1)
            low, high = 10 ** powers[0], 10 ** powers[-1]
            self._mark(powers)
        else:
            low, high = low - MARGIN * (high - low), high + MARGIN * (high - low)
        y_scale = self._scales["y"].copy()
        y_scale["range"] = float(low), float(high)
        scales = {**self._scales, "y": y_scale}
        if scales != self._chart.scales:
            self._chart.scales = scales

    def _mark(self, powers: Vector) -> None:
        """Mark powers of ten: by itself uPlot draws nine lines between two, and 0 for 0.0001."""
        x_axis, y_axis = self._axes
        marks = {
            "splits": tuple((10.0**powers).tolist()),
            "values": tuple(f"{mark:g}" for mark in 10.0**powers),
        }
        if any(y_axis.get(name) != wanted for name, wanted in marks.items()):
            self._axes = x_axis, {**y_axis, **marks}  # type: ignore[typeddict-item]
            self._chart.axes = self._axes

    def name(self, title: str) -> None:
        """Change its title."""
        if title != self._chart.title:
            self._chart.title = title

    @property
    def visible(self) -> bool:
        """Whether it is seen."""
        return bool(self._chart.visible)

    @visible.setter
    def visible(self, visible: bool) -> None:
        if visible != self._chart.visible:
            self._chart.visible = visible

    def remove(self) -> None:
        """Take it from the page."""
        self._chart.remove()


def _transparent(shade: Shade) -> str:
    return f"{shade.color}{round(255 * shade.opacity):02x}"
