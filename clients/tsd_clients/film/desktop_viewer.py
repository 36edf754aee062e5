"""MuJoCo's own viewer on a desktop, while a repetition runs."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any

import mujoco

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.exceptions import NotAvailable
from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import State
from tsd_clients.film.picture_scene import load_picture_scene
from tsd_clients.simulator.state_map import StateMap

# how often the window shows a new state: as a screen does [s]
INTERVAL = 1 / 60
ELSEWHERE = "without one 'tsd view' shows a run in a browser, --video makes a film of it"


class DesktopViewer:
    """Shows the newest state of a run; an observer.

    A tick that is shown takes its time: the window's lock and a copy of the state.
    """

    def __init__(self, robot: Robot, model: Any, data: Any, handle: Any) -> None:
        """Show a robot.

        Args:
            model: ``mujoco.MjModel`` of the picture's scene.
            data: ``mujoco.MjData`` that the window shows.
            handle: ``mujoco.viewer.Handle`` of the window.
        """
        self._model, self._data, self._handle = model, data, handle
        self._state_map = StateMap(robot, model)
        self._shown = -INTERVAL

    def start(self, setting: Setting) -> None:
        """Show the first state at once."""
        self._shown = -INTERVAL

    def tick(self, moment: Moment) -> None:
        """Show the state, if it is time."""
        now = perf_counter()
        if now - self._shown < INTERVAL or not self._handle.is_running():
            return
        self._shown = now
        self._show(moment.state if moment.truth is None else moment.truth.state)

    def missed(self, moment: Moment) -> None:
        """Show the state, if it is time."""
        self.tick(moment)

    def lap(self, lap: Lap) -> None:
        """Show nothing new."""

    def end(self, outcome: str) -> None:
        """Leave the last state on the screen."""

    def _show(self, state: State) -> None:
        with self._handle.lock():
            self._state_map.write(self._data, state)
            mujoco.mj_forward(self._model, self._data)
        self._handle.sync()


def check_display() -> None:
    """Refuse a window where there is no desktop.

    Raises:
        NotAvailable: If no display is named, or it does not answer.
    """
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise NotAvailable("--viewer", "a desktop (DISPLAY is not set)", ELSEWHERE)
    import glfw

    # tried here: where MuJoCo itself finds none it ends the process
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        is_there = glfw.init()
    if not is_there:
        raise NotAvailable("--viewer", "a desktop (its display does not answer)", ELSEWHERE)
    glfw.terminate()


@contextmanager
def open_desktop_viewer(robot: Robot) -> Iterator[DesktopViewer]:
    """Open MuJoCo's viewer, and close it at the end.

    Raises:
        NotAvailable: If there is no desktop to open a window on.
        RobotFileError: If the robot cannot be drawn.
    """
    check_display()
    import mujoco.viewer as windows

    model = load_picture_scene(robot)
    data = mujoco.MjData(model)
    with windows.launch_passive(model, data, show_left_ui=False, show_right_ui=False) as handle:
        yield DesktopViewer(robot, model, data, handle)
