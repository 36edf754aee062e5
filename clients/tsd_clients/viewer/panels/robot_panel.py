"""The robots of all runs, side by side in the 3D view."""

from __future__ import annotations

from html import escape

import viser

from tsd_casadi.exceptions import TsdError
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_clients.viewer.panel import Panel
from tsd_clients.viewer.shape_cache import ShapesOfRobot
from tsd_clients.viewer.shown_robot import ShownRobot
from tsd_clients.viewer.shown_run import Runs, ShownRun
from tsd_clients.viewer.surroundings import APART, Surroundings
from tsd_clients.viewer.view_choice import ViewChoice


class RobotPanel(Panel):
    """Robots as they move, and what of them is shown."""

    title = "View"

    def __init__(self, runs: Runs) -> None:
        """Show the robots of runs."""
        self._runs = runs
        self._waiting: dict[str, tuple[Robot, ShapesOfRobot]] = {}
        self._robots: dict[str, ShownRobot] = {}
        self._refused: dict[str, str] = {}

    def build(self, server: viser.ViserServer) -> None:
        """Add the ground, and boxes to choose with."""
        self._server = server
        self._surroundings = Surroundings(server)
        self._choice = ViewChoice(server.gui)
        self._choice.shadows.on_update(
            lambda _: self._surroundings.cast_shadows(bool(self._choice.shadows.value))
        )
        self._drawn = server.gui.add_html("")

    def update(self, now: float) -> None:
        """Show the newest tick of every run."""
        shown = {run.label.key: run for run in self._runs.shown}
        for key in set(self._robots) - set(shown):
            self._robots.pop(key).remove()
        for key in set(self._waiting) - set(shown):
            self._waiting.pop(key)[1].close()
        came = [self._take_in(run) for key, run in shown.items() if key not in self._robots]
        if any(came):
            self._arrange(list(shown))
        self._tell(shown)
        for key, robot in self._robots.items():
            robot.show(shown[key], self._choice)

    def _tell(self, shown: dict[str, ShownRun]) -> None:
        """Say which robots are drawn, and why others are not."""
        drawn = " ".join(shown[key].label.robot for key in self._robots)
        told = [
            *(f"{waiting[0].name} is made ready" for waiting in self._waiting.values()),
            *(text for key, text in self._refused.items() if key in shown),
        ]
        lines = "".join(f"<p>{escape(text)}</p>" for text in told)
        content = f"<div data-drawn='{escape(drawn)}' style='padding:0 10px'>{lines}</div>"
        if content != self._drawn.content:
            self._drawn.content = content

    def _take_in(self, run: ShownRun) -> bool:
        """Add a run's robot when its shapes are there; whether they are."""
        key = run.label.key
        if key in self._refused:
            return False
        try:
            if key not in self._waiting:
                robot = load_robot(run.label.robot_file)
                self._waiting[key] = robot, ShapesOfRobot(robot)
            robot, waiting = self._waiting[key]
            shapes = waiting.take()
        except (TsdError, OSError) as error:
            self._waiting.pop(key, None)
            self._refused[key] = f"{run.label.robot} is not drawn: {error}"
            return False
        if shapes is None:
            return False
        del self._waiting[key]
        root = f"/robots/{len(self._robots)}-{abs(hash(key))}"
        self._robots[key] = ShownRobot(self._server.scene, root, robot, shapes, run)
        return True

    def _arrange(self, order: list[str]) -> None:
        """Put the robots side by side, the first on the left as one looks at them."""
        robots = [self._robots[key] for key in order if key in self._robots]
        for number, robot in enumerate(robots):
            robot.place(APART * (number - (len(robots) - 1) / 2))
        self._surroundings.look_at(len(robots), max(robot.height for robot in robots))
