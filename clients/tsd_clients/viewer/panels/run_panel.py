"""Which run the charts are of, and how it is."""

from __future__ import annotations

from html import escape
from typing import Any

import viser

from tsd_clients.viewer.panel import Panel
from tsd_clients.viewer.shown_run import Runs, ShownRun

NONE = "no run yet"
HOW = (
    "<p style='font-size:13px;margin:2px 0 8px;padding:0 10px'>Start one, for instance "
    "<code>tsd simulate squat --laps 20 --pace 1</code>; it appears here by itself.</p>"
)


class RunPanel(Panel):
    """A list to choose from; a run that begins is chosen by itself.

    Attributes:
        chosen: The run, if there is one.
    """

    def __init__(self, runs: Runs) -> None:
        """Choose among runs."""
        self._runs = runs
        self.chosen: ShownRun | None = None
        self._keys: list[str] = []

    def build(self, server: viser.ViserServer) -> None:
        """Add the list."""
        # viser declares values that can be set as if they could not
        self._list: Any = server.gui.add_dropdown("run", [NONE], initial_value=NONE)
        self._state = server.gui.add_html(HOW)

    def update(self, now: float) -> None:
        """Offer what there is, and say how the chosen one is."""
        shown = list(self._runs.shown)
        keys = [run.label.key for run in shown]
        options = _distinct([run.label.title for run in shown]) or [NONE]
        if keys != self._keys or tuple(self._list.options) != tuple(options):
            newest = keys[-1:] if set(keys) - set(self._keys) else []
            wanted = newest or ([] if self.chosen is None else [self.chosen.label.key])
            self._keys = keys
            self._list.options = options
            self._list.value = (
                options[keys.index(wanted[0])] if wanted[0:] and wanted[0] in keys else options[-1]
            )
        place = options.index(self._list.value) if self._list.value in options else 0
        self.chosen = shown[place] if shown else None
        text = HOW if self.chosen is None else _state(self.chosen)
        if text != self._state.content:
            self._state.content = text


def _state(run: ShownRun) -> str:
    ticks = run.ticks
    parts = [run.state]
    if len(ticks):
        lap = int(ticks.lap[-1])
        parts += [f"{ticks.time[-1]:.1f} s", "holding" if lap < 0 else f"lap {lap + 1}"]
    state = escape(", ".join(parts))
    return (
        f"<p style='font-size:13px;margin:2px 0 8px;padding:0 10px'>"
        f"<span style='color:#868e96'>{escape(run.label.parameters)}</span> "
        f"<span data-run='{state}'>{state}</span></p>"
    )


def _distinct(titles: list[str]) -> list[str]:
    """Put a number behind titles that are there several times."""
    return [
        title if titles.count(title) == 1 else f"{title} #{titles[: place + 1].count(title)}"
        for place, title in enumerate(titles)
    ]
