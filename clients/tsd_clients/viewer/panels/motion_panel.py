"""How well the motion is followed: error, feedback and feedforward of each axis."""

from __future__ import annotations

import viser

from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_clients.viewer.panel import Panel
from tsd_clients.viewer.panels.run_panel import RunPanel
from tsd_clients.viewer.shown_run import RunLabel
from tsd_clients.viewer.strip_chart import Line, StripChart

# charts are drawn anew so often [s]
PERIOD = 0.1
# what is right below what is seen, broad enough to stand out behind it
TRUE, SEEN = Line("true", "#ced4da", 5.0), Line("as the controller sees it", "#1c7ed6")
FEEDBACK, FEEDFORWARD = Line("feedback", "#1c7ed6"), Line("feedforward", "#e8590c")
ROUND_TRIP = Line("longest round trip", "#495057")


class MotionPanel(Panel):
    """Two charts for each learned axis, and one of the time that ticks take."""

    title = "Motion"

    def __init__(self, runs: RunPanel) -> None:
        """Show the chosen run."""
        self._runs = runs
        self._label: RunLabel | None = None
        self._errors: list[StripChart] = []
        self._accelerations: list[StripChart] = []
        self._drawn = float("-inf")

    def build(self, server: viser.ViserServer) -> None:
        """Add the chart that every run has."""
        self._gui = server.gui
        self._folder = server.gui.add_folder(None)
        self._latency = StripChart(server.gui, "time of a tick [ms]", [ROUND_TRIP], height=120)

    def update(self, now: float) -> None:
        """Draw the last seconds."""
        run = self._runs.chosen
        if run is None or now < self._drawn + PERIOD:
            return
        self._drawn = now
        if run.label is not self._label:
            self._label = run.label
            self._add_charts(run.label)
        ticks = run.ticks
        for number, (error, acceleration) in enumerate(
            zip(self._errors, self._accelerations, strict=True)
        ):
            error.show(
                ticks.time,
                [1000 * ticks.true_error[:, number], 1000 * ticks.error[:, number]],
            )
            acceleration.show(ticks.time, [ticks.feedback[:, number], ticks.feedforward[:, number]])
        self._latency.show(ticks.time, [ticks.tick_us / 1000])

    def _add_charts(self, label: RunLabel) -> None:
        for chart in (*self._errors, *self._accelerations):
            chart.remove()
        self._errors, self._accelerations = [], []
        with self._folder:
            for axis in label.axes[: label.learned]:
                unit = unit_of_axis(axis)
                self._errors.append(StripChart(self._gui, f"{axis}: error [m{unit}]", [TRUE, SEEN]))
                self._accelerations.append(
                    StripChart(
                        self._gui,
                        f"{axis}: acceleration [{unit}/s²]",
                        [FEEDBACK, FEEDFORWARD],
                    )
                )
