"""How learning goes: the error of each iteration, what the last one changed, what it leaves."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import viser

from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.wire.learner import EntryMessage
from tsd_casadi.wire.telemetry import IterationRecorded
from tsd_clients.viewer.known_motion import place_of
from tsd_clients.viewer.learner_link import LearnerLink
from tsd_clients.viewer.learning_lines import error_chart, share_lines, weight_lines
from tsd_clients.viewer.learning_story import ErrorHistory, told
from tsd_clients.viewer.line_chart import STYLE, LineChart
from tsd_clients.viewer.motion_controls import offer
from tsd_clients.viewer.panel import Panel
from tsd_clients.viewer.prediction import PHASE, LearnedCurve

NEWEST = "what was learned last"
# entries to choose from, those that were learned last
MOST = 100
UNITS = ("m", "rad")
NOTHING_LEARNED = (
    "**Nothing was learned yet.** `tsd learn squat --model-error 0.1` learns, and its error "
    "appears here from repetition to repetition."
)
LATER = (
    "What an iteration changed, and what it leaves of each harmonic, is shown of what is learned "
    "while this page is open."
)


class LearningPanel(Panel):
    """Errors by iteration, weights before and after, contraction."""

    title = "Learning"

    def __init__(
        self, link: LearnerLink, recorded: Callable[[], Sequence[IterationRecorded]]
    ) -> None:
        """Show what a learner knows and what runs tell.

        Args:
            recorded: Gives the iterations that watched runs told about, in order.
        """
        self._link, self._recorded = link, recorded
        self._drawn: object = None
        self._looked_at: EntryMessage | None = None

    def build(self, server: viser.ViserServer) -> None:
        """Add charts and text."""
        gui = server.gui
        gui.add_html(STYLE)
        self._state = gui.add_markdown("")
        self._entry = gui.add_dropdown("Entry", (NEWEST,), visible=False)
        self._errors = {
            unit: LineChart(
                gui, "RMS error", "iteration", f"m{unit}", counted=True, logarithmic=True
            )
            for unit in UNITS
        }
        self._axis = gui.add_dropdown(
            "Axis", ("–",), hint="Whose feedforward and harmonics are shown.", visible=False
        )
        self._weights = LineChart(gui, "Feedforward", "phase [rad]", "", over_phase=True)
        self._shares = LineChart(
            gui, "What an iteration leaves, by harmonic", "harmonic", "share", counted=True
        )
        self._text = gui.add_markdown("")
        for chart in (*self._errors.values(), self._weights, self._shares):
            chart.visible = False

    def update(self, now: float) -> None:
        """Draw what was chosen, where something changed."""
        entries = sorted(self._link.entries, key=lambda each: (each.updated, each.entry))[-MOST:][
            ::-1
        ]
        offer(self._entry, [NEWEST, *map(_name, entries)] if entries else [])
        state = self._state_text(bool(entries))
        if state != self._state.content:
            self._state.content = state
        if not entries:
            return
        entry = next((each for each in entries if _name(each) == self._entry.value), entries[0])
        if entry is not self._looked_at:
            self._looked_at = entry
            self._link.look_at(entry)
            offer(self._axis, by_error(entry))
        told_by = [each for each in self._recorded() if _is_of(each, entry)]
        recorded = told_by[-1] if told_by else None
        curve = self._link.curve
        if curve is not None and curve.entry.entry != entry.entry:
            curve = None
        shown = entry, self._axis.value, recorded, curve
        if shown != self._drawn:
            self._drawn = shown
            self._draw(entry, str(self._axis.value), recorded, curve)

    def _state_text(self, is_something: bool) -> str:
        if self._link.trouble:
            return f"**The learner does not answer**: {self._link.trouble}"
        if not is_something:
            return NOTHING_LEARNED
        return "How the error shrinks from one repetition to the next; shades: how well it repeats."

    def _draw(
        self,
        entry: EntryMessage,
        axis: str,
        recorded: IterationRecorded | None,
        curve: LearnedCurve | None,
    ) -> None:
        for unit, chart in self._errors.items():
            axes = [each.name for each in entry.axes if each.unit == unit]
            chart.visible = bool(axes)
            if axes:
                histories = {name: ErrorHistory.of(entry.iterations, name) for name in axes}
                chart.show(*error_chart(histories))
        lines = weight_lines(axis, recorded, curve)
        self._weights.visible = bool(lines)
        if lines:
            self._weights.name(f"Feedforward along {axis} [{unit_of_axis(axis)}/s²]")
            self._weights.show(PHASE, lines)
        shares = share_lines(axis, recorded)
        self._shares.visible = bool(shares)
        if shares:
            self._shares.name(f"What an iteration leaves of the error along {axis}, by harmonic")
            self._shares.show(np.arange(len(shares[0].values), dtype=float), shares)
        notes = [*told(entry, recorded), *([] if recorded is not None else [LATER])]
        self._text.content = "\n".join(f"- {note}" for note in notes)


def by_error(entry: EntryMessage) -> list[str]:
    """Sort the axes of an entry by the error that there was at first, the largest first."""
    tested = [each.errors for each in entry.iterations if each.errors is not None]

    def error(axis: str) -> float:
        return tested[0][axis].rms if tested and axis in tested[0] else 0.0

    return sorted((each.name for each in entry.axes), key=lambda axis: -error(axis))


def _name(entry: EntryMessage) -> str:
    return f"{entry.entry}: {entry.robot} {entry.motion}, {place_of(entry)}"


def _is_of(recorded: IterationRecorded, entry: EntryMessage) -> bool:
    return recorded.entry == entry.entry and recorded.motion == entry.motion
