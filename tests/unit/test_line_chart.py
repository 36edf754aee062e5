from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser")

from tsd_clients.viewer.line_chart import Line, LineChart


class Gui:
    """Keeps what a chart is told."""

    def add_uplot(self, data: Any, series: Any, **options: Any) -> SimpleNamespace:
        self.chart = SimpleNamespace(data=data, series=series, bands=(), **options)
        return self.chart


def chart_of(values: list[float], *, logarithmic: bool) -> SimpleNamespace:
    gui: Any = Gui()
    chart = LineChart(gui, "error", "iteration", "mm", logarithmic=logarithmic)
    chart.show(np.arange(len(values), dtype=float), [Line("com.z", np.array(values), "#000000")])
    drawn: SimpleNamespace = gui.chart
    return drawn


@pytest.mark.parametrize(
    ("values", "marks"),
    [
        ([15.0, 0.1, 0.0016], ("0.001", "0.01", "0.1", "1", "10", "100")),
        ([1.0, 1.0], ("1", "10")),
        ([2e-5, float("nan"), 5e-5], ("1e-05", "0.0001")),
    ],
)
def test_a_logarithmic_axis_has_a_mark_at_each_power(
    values: list[float], marks: tuple[str, ...]
) -> None:
    drawn = chart_of(values, logarithmic=True)
    y_axis = drawn.axes[1]
    assert y_axis["values"] == marks
    assert y_axis["splits"] == pytest.approx([float(mark) for mark in marks])
    low, high = drawn.scales["y"]["range"]
    assert low <= np.nanmin(values) and np.nanmax(values) <= high
    assert (low, high) == pytest.approx((float(marks[0]), float(marks[-1])))


def test_a_line_with_gaps_has_a_range_and_one_without_finds_its_own() -> None:
    assert "range" not in chart_of([1.0, 2.0], logarithmic=False).scales["y"]
    low, high = chart_of([1.0, float("nan"), 2.0], logarithmic=False).scales["y"]["range"]
    assert low < 1.0 < 2.0 < high
    assert "range" not in chart_of([float("nan")] * 2, logarithmic=False).scales["y"]
