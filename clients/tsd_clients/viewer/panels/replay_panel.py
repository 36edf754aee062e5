"""Play, halt and move through a log."""

from __future__ import annotations

from typing import Any

import viser

from tsd_clients.viewer.panel import Panel
from tsd_clients.viewer.replay import Replay

SPEEDS = {"1/4": 0.25, "1/2": 0.5, "1": 1.0, "2": 2.0, "4": 4.0}
STEP = 0.01  # s
# the slider follows so often [s]
PERIOD = 0.1
PLAY, PAUSE = "Play", "Pause"


class ReplayPanel(Panel):
    """A time slider and a button."""

    def __init__(self, replay: Replay) -> None:
        """Move a replay."""
        self._replay = replay
        self._moved: float | None = None
        self._drawn = float("-inf")

    def build(self, server: viser.ViserServer) -> None:
        """Add slider, button and speeds."""
        gui, replay = server.gui, self._replay
        # viser declares values that can be set as if they could not
        self._time: Any = gui.add_slider(
            "time [s]", min=replay.begin, max=replay.end, step=STEP, initial_value=replay.begin
        )
        self._button = gui.add_button(PAUSE)
        self._speed = gui.add_button_group("speed", tuple(SPEEDS))

        @self._time.on_update
        def _(event: viser.GuiEvent[viser.GuiSliderHandle[float]]) -> None:
            # not of our own following
            if event.client is not None:
                self._moved = float(self._time.value)

        @self._button.on_click
        def _(_: viser.GuiEvent[viser.GuiButtonHandle]) -> None:
            replay.playing = not replay.playing

        @self._speed.on_click
        def _(_: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
            replay.speed = SPEEDS[self._speed.value]

    def update(self, now: float) -> None:
        """Follow what is shown, or go where the slider was moved to."""
        moved, self._moved = self._moved, None
        if moved is not None:
            self._replay.playing = False
            self._replay.move_to(moved)
        word = PAUSE if self._replay.playing else PLAY
        if self._button.label != word:
            self._button.label = word
        if self._replay.playing and now >= self._drawn + PERIOD:
            self._drawn = now
            self._time.value = self._replay.time
