from __future__ import annotations

import sys
from contextlib import contextmanager
from itertools import count
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from tsd_casadi import Controller, Robot
from tsd_casadi.exceptions import NotAvailable
from tsd_casadi.motions.squat import Squat
from tsd_clients import MujocoSimulator
from tsd_clients.film import desktop_viewer
from tsd_clients.film.desktop_viewer import DesktopViewer, check_display
from tsd_clients.film.picture_scene import load_picture_scene
from tsd_clients.simulator.state_map import StateMap


class Window:
    """What MuJoCo's handle of a window offers; closed by its user after some pictures."""

    def __init__(self, data: Any, pictures: int) -> None:
        self.data, self.left, self.seen, self.locked = data, pictures, list[np.ndarray](), False

    def is_running(self) -> bool:
        return self.left > 0

    @contextmanager
    def lock(self) -> Any:
        self.locked = True
        yield
        self.locked = False

    def sync(self) -> None:
        assert not self.locked
        self.left -= 1
        self.seen.append(self.data.qpos.copy())


def test_the_window_shows_the_true_state_until_it_is_closed(
    robot: Robot, controller: Controller, monkeypatch: pytest.MonkeyPatch
) -> None:
    # a tenth of a picture between two looks; a hair more, for the tenth to be there
    clock = count(step=1.001 * desktop_viewer.INTERVAL / 10)
    monkeypatch.setattr(desktop_viewer, "perf_counter", lambda: next(clock))
    model = load_picture_scene(robot)
    data = mujoco.MjData(model)
    window = Window(data, pictures=40)
    viewer = DesktopViewer(robot, model, data, window)
    run = MujocoSimulator(robot, 0.1).run(controller, Squat(0.02, 1.0), laps=2, observers=[viewer])
    assert not run.fell
    assert len(window.seen) == 40
    state_map = StateMap(robot, model)
    for place, qpos in enumerate(window.seen[:5]):
        data.qpos[:] = qpos
        # the first tick at once, then one of ten
        assert state_map.read(data).q == pytest.approx(run.log["q"][10 * place], abs=1e-6)


@pytest.mark.parametrize(("display", "answers"), [("", True), (":77", False)])
def test_without_a_desktop_it_says_what_else_there_is(
    monkeypatch: pytest.MonkeyPatch, display: str, answers: bool
) -> None:
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setenv("DISPLAY", display)
    glfw = SimpleNamespace(init=lambda: answers, terminate=lambda: None)
    monkeypatch.setitem(sys.modules, "glfw", glfw)
    with pytest.raises(NotAvailable, match=r"--viewer needs a desktop.*'tsd view'.*--video"):
        check_display()


def test_with_a_desktop_it_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    ended: list[bool] = []
    glfw = SimpleNamespace(init=lambda: True, terminate=lambda: ended.append(True))
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setitem(sys.modules, "glfw", glfw)
    check_display()
    assert ended
