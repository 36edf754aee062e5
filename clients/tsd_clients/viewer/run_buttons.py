"""Buttons that simulate and learn a motion as the local user."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from html import escape

import viser

from tsd_casadi.exceptions import TsdError
from tsd_casadi.wire.run_directory import running
from tsd_clients.viewer.child_run import ChildRun
from tsd_clients.viewer.explorer import Asked
from tsd_clients.viewer.run_wish import (
    FEEDFORWARDS,
    LARGEST_MODEL_ERROR,
    MOST_ITERATIONS,
    RunWish,
)

# of what a run printed, as high as a small table [pixels]
HEIGHT = 220
BUTTONS = SIMULATE, LEARN, STOP = "Simulate", "Learn", "Stop"
NEUTRAL, GOOD, BAD = "#868e96", "#2b8a3e", "#c92a2a"


class RunButtons:
    """Runs one thing at a time, and shows how it goes."""

    def __init__(self, program: Sequence[str], robots: Callable[[], Mapping[str, str]]) -> None:
        """Prepare to run.

        Args:
            program: Words that start 'tsd'.
            robots: Gives what '--robot' takes for the robots that are known here, by name.
        """
        self._program, self._robots = list(program), robots
        self._run: ChildRun | None = None
        self._refusal = ""
        self._clicked = ""

    def build(self, gui: viser.GuiApi) -> None:
        """Add the buttons, how it goes, and what else a run needs to know."""
        self._buttons = gui.add_button_group(
            "Run it here",
            BUTTONS,
            hint="At the sliders' values: one repetition, or as many as it takes to learn.",
        )
        self._buttons.on_click(lambda _: self._click(str(self._buttons.value)))
        self._state = gui.add_html("")
        with gui.add_folder("How it is run", expand_by_default=False):
            self._feedforward = gui.add_dropdown(
                "Feedforward", FEEDFORWARDS, hint="What a simulation feeds forward."
            )
            self._iterations = gui.add_slider("Iterations", 1, MOST_ITERATIONS, 1, 2)
            self._error = gui.add_slider(
                "Model error",
                0.0,
                LARGEST_MODEL_ERROR,
                0.01,
                0.1,
                hint="By what share the controller believes the simulated robot too heavy.",
            )
            self._pace = gui.add_checkbox(
                "In real time", True, hint="To be watched; otherwise as fast as it goes."
            )

    def update(self, asked: Asked | None) -> None:
        """Do what was clicked, and show how it goes.

        Args:
            asked: At what the sliders stand.
        """
        clicked, self._clicked = self._clicked, ""
        if clicked == STOP and self._run is not None:
            self._run.stop()
        elif clicked and clicked != STOP and asked is not None:
            self._start(clicked, asked)
        state = self._state_html()
        if state != self._state.content:
            self._state.content = state

    def poll(self, now: float) -> None:
        """End what was told to stop and does not, also while nobody looks."""
        if self._run is not None:
            self._run.poll()

    def close(self) -> None:
        """End what runs."""
        if self._run is not None:
            self._run.close()

    def _click(self, button: str) -> None:
        self._clicked = button

    def _start(self, button: str, asked: Asked) -> None:
        if self._run is not None and self._run.code is None:
            return  # one at a time; the card says which
        wish = RunWish(
            command="simulate" if button == SIMULATE else "learn",
            known=asked.known,
            parameters=asked.parameters,
            model_error=float(self._error.value),
            feedforward=str(self._feedforward.value),
            iterations=int(self._iterations.value),
            in_real_time=bool(self._pace.value),
        )
        try:
            words = wish.arguments(self._robots(), endpoints_here(asked.known.robot))
        except TsdError as error:
            self._refusal = str(error)
            return
        self._refusal = ""
        self._run = ChildRun([*self._program, *words])

    def _state_html(self) -> str:
        if self._refusal:
            return _told("refused", BAD, f"Refused: {self._refusal}")
        run = self._run
        if run is None:
            return ""
        words = shlex.join(["tsd", *run.words[len(self._program) :]])
        if run.code is None:
            return _told("running", NEUTRAL, f"running for {run.seconds:.0f} s", words, run.output)
        if run.code == 0:
            return _told("done", GOOD, f"done in {run.seconds:.0f} s", words, run.output)
        return _told("failed", BAD, f"ended with {run.code}", words, run.output)


def endpoints_here(robot: str) -> list[str]:
    """List where the services are that a run of a robot needs.

    Returns:
        Endpoints of controller and learner, that of the learner only where no controller
        for the robot runs here.

    Raises:
        RunDirectoryUnusable: If the run directory is not one.
    """
    records = sorted(running(), key=lambda each: each.started)
    controllers = [each for each in records if (each.role, each.robot) == ("controller", robot)]
    learners = [each for each in records if each.role == "learner"]
    return [each[-1].endpoints[0] for each in (controllers, learners) if each]


def _told(state: str, color: str, title: str, words: str = "", output: str = "") -> str:
    return (
        f"<div data-child='{state}' style='border-left:4px solid {color};padding:2px 10px;"
        f"font-size:12px'><b style='color:{color}'>{escape(title)}</b>"
        f"<div><code>{escape(words)}</code></div>"
        f"<pre style='font-size:9px;line-height:1.3;overflow:auto;max-height:{HEIGHT}px'>"
        f"{escape(output)}</pre></div>"
    )
