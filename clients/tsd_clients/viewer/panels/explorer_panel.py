"""What would be fed forward: a motion, a slider for each of its parameters, and the answer."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
import viser

from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_clients.viewer.explorer import Asked
from tsd_clients.viewer.known_motion import KnownMotion, place_of
from tsd_clients.viewer.learner_link import LearnerLink
from tsd_clients.viewer.line_chart import COLORS, STYLE, Line, LineChart, Shade
from tsd_clients.viewer.motion_controls import MotionControls
from tsd_clients.viewer.panel import Panel
from tsd_clients.viewer.prediction import PHASE, LearnedCurve, Prediction
from tsd_clients.viewer.run_buttons import RunButtons

AS_RUN = "learned where it is, else generalised"
GENERALIZED = "always generalised"
NOTHING_LEARNED = (
    "**Nothing was learned yet.** `tsd learn squat --amplitude 0.04 --model-error 0.1` at two or "
    "three amplitudes, and a slider appears here."
)
NOT_ALLOWED = "`tsd view --allow-run` has buttons here that simulate and learn what is shown"
ANSWER, OF_ENTRIES = COLORS[0], ("#495057", "#868e96", "#adb5bd", "#ced4da")


class ExplorerPanel(Panel):
    """Sliders for a motion's parameters, and what the learner answers for them."""

    title = "Explorer"

    def __init__(self, link: LearnerLink, buttons: RunButtons | None = None) -> None:
        """Show what a learner answers.

        Args:
            buttons: Run a motion at the sliders' values; None where that is not allowed.
        """
        self._link, self._buttons = link, buttons
        self._charts: dict[str, LineChart] = {}
        self._shown: object = None
        self._listed = -1
        self._asked: Asked | None = None

    def build(self, server: viser.ViserServer) -> None:
        """Add controls and text; charts come with the first answer."""
        self._gui = server.gui
        server.gui.add_html(STYLE)
        self._state = server.gui.add_markdown("")
        self._controls = MotionControls(server.gui)
        self._kind = server.gui.add_dropdown(
            "Answer",
            (AS_RUN, GENERALIZED),
            hint="Where an entry is exactly there: what was learned, or what the others predict.",
            visible=False,
        )
        self._beyond = server.gui.add_checkbox(
            "Extrapolate",
            False,
            hint="Answer outside the learned range too; it is refused otherwise.",
            visible=False,
        )
        if self._buttons is not None:
            self._buttons.build(server.gui)
        self._answer = server.gui.add_html("")
        self._folder = server.gui.add_folder(None)
        self._notes = server.gui.add_markdown("")

    @property
    def asked(self) -> Asked | None:
        """What the controls ask now; None while nothing is known."""
        known = self._controls.known
        if known is None:
            return None
        kind = "generalised" if self._kind.value == GENERALIZED else None
        return Asked(known, self._controls.parameters, kind, bool(self._beyond.value))

    def update(self, now: float) -> None:
        """Ask where something was moved, and show what was answered."""
        if self._link.listed != self._listed:
            self._listed = self._link.listed
            self._controls.offer(self._link.motions, self._link.declaration)
            for control in (self._kind, self._beyond):
                control.visible = bool(self._link.motions)
        self._controls.update()
        asked = self.asked
        if asked is not None and asked != self._asked:
            self._asked = asked
            self._link.ask(asked)
        if self._buttons is not None:
            self._buttons.update(asked)
        state = self._state_text()
        if state != self._state.content:
            self._state.content = state
        answered = self._link.prediction
        if answered is not None and answered[1] is not self._shown:
            self._shown = answered[1]
            self._draw(*answered)

    def _state_text(self) -> str:
        if self._link.trouble:
            return f"**The learner does not answer**: {self._link.trouble}"
        if not self._link.motions:
            return NOTHING_LEARNED
        return "Move a slider and see what would be fed forward there."

    def _draw(self, asked: Asked, prediction: Prediction) -> None:
        self._answer.content = answer_html(prediction)
        axes = by_size(asked.known, prediction)
        if list(self._charts) != axes:
            for chart in self._charts.values():
                chart.remove()
            with self._folder:
                self._charts = {axis: self._chart(axis) for axis in axes}
        for axis, chart in self._charts.items():
            chart.show(PHASE, lines_of(prediction, axis), shades_of(prediction, axis))
        self._notes.content = notes_text(prediction, [] if self._buttons else [NOT_ALLOWED])

    def _chart(self, axis: str) -> LineChart:
        label = f"{unit_of_axis(axis)}/s²"
        return LineChart(
            self._gui, f"Feedforward along {axis}", "phase [rad]", label, over_phase=True
        )


def by_size(known: KnownMotion, prediction: Prediction) -> list[str]:
    """Sort axes by what is fed forward around, most first; the same while a slider moves."""

    def size(axis: str) -> float:
        curves = [np.abs(each.over_phase(axis)).max() for each in prediction.around]
        return float(max(curves, default=0.0))

    # half a power of ten: neighbouring entries do not swap axes
    return sorted(known.axes, key=lambda axis: -round(2 * np.log10(size(axis) + 1e-9)))


def lines_of(prediction: Prediction, axis: str) -> list[Line]:
    """Make the lines along an axis: the answer, and the entries around it."""
    answer = prediction.over_phase(axis)
    lines = [
        Line(
            f"entry {curve.entry.entry}",
            curve.over_phase(axis),
            color,
            width=2.5 if curve.entry.entry == prediction.exact else 1.0,
            dash=(6.0, 4.0),
        )
        for curve, color in zip(prediction.around, OF_ENTRIES, strict=False)
    ]
    lines.reverse()  # the nearest one in front
    return lines if answer is None else [*lines, Line("answer", answer, ANSWER, width=2.5)]


def shades_of(prediction: Prediction, axis: str) -> list[Shade]:
    """Make the bands along an axis, the wider one behind."""
    shades = []
    for kind, opacity in (("simultaneous", 0.14), ("pointwise", 0.28)):
        band = prediction.band(kind, axis)
        if band is not None:
            shades.append(Shade(*band, ANSWER, opacity))
    return shades


def answer_html(prediction: Prediction) -> str:
    """Say what came of the question, for people: an answer or a refusal, with its reason."""
    if prediction.feedforward is None:
        hint = "Tick 'Extrapolate' to see it all the same." if prediction.is_beyond else ""
        return _card("refused", "#c92a2a", "Refused", [prediction.refusal], hint)
    kind = prediction.feedforward.kind
    color = "#2b8a3e" if kind == "learned" else ANSWER
    title = "Learned" if kind == "learned" else "Generalised"
    return _card(kind, color, f"{title}, {prediction.origin}", prediction.disagreeing)


def notes_text(prediction: Prediction, said: Sequence[str] = ()) -> str:
    """Say what is to be known of answer and curves, for people."""
    notes = "\n".join(f"- {note}" for note in [*prediction.notes(), *said])
    return f"{around_text(prediction)}\n\n{notes}"


def around_text(prediction: Prediction) -> str:
    """List the entries around, for people."""
    if not prediction.around:
        return ""
    rows = "\n".join(_around_row(curve) for curve in prediction.around)
    return f"| entry | learned at | iteration |\n| --- | --- | --- |\n{rows}"


def _around_row(curve: LearnedCurve) -> str:
    return f"| {curve.entry.entry} | {place_of(curve.entry)} | {curve.feedforward.iteration} |"


def _card(state: str, color: str, title: str, lines: list[str], hint: str = "") -> str:
    said = "".join(f"<div>{escape(line)}</div>" for line in lines)
    tail: Any = f"<div style='color:#868e96'>{escape(hint)}</div>" if hint else ""
    return (
        f"<div data-answer='{escape(state)}' style='border-left:4px solid {color};"
        f"padding:2px 10px;margin:6px 0;font-size:12px'>"
        f"<b style='color:{color}'>{escape(title)}</b>{said}{tail}</div>"
    )
