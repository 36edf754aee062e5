"""One run's robot in the 3D view, with all its marks."""

from __future__ import annotations

import numpy as np
import viser

from tsd_casadi.robot.ghost import ghost_posture
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector
from tsd_clients.viewer.contact_marks import ContactMarks
from tsd_clients.viewer.mass_marks import MassMarks
from tsd_clients.viewer.robot_body import RobotBody, unit
from tsd_clients.viewer.robot_shapes import Shape
from tsd_clients.viewer.shown_run import ShownRun
from tsd_clients.viewer.view_choice import ViewChoice


class ShownRobot:
    """A robot and its marks, at its place in the row.

    Attributes:
        height: How tall it is at home [m].
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        root: str,
        robot: Robot,
        shapes: list[Shape],
        run: ShownRun,
    ) -> None:
        """Add everything.

        Args:
            root: Name of the node that it hangs on.
        """
        label = run.label
        self._root = scene.add_frame(root, show_axes=False)
        self._body = RobotBody(scene, f"{root}/body", robot, shapes)
        self._contacts = ContactMarks(scene, root, robot)
        self._mass = MassMarks(scene, root, robot, label.all_axes, label.axes)
        self._ghost = RobotBody(scene, f"{root}/ghost", robot, shapes, ghost=True)
        self._robot, self._moved = robot, label.axes
        self._axes = tuple(f"{task}.{axis}" for task, axis in label.all_axes)
        self._body.show(robot.home.q)
        self._ghost.show(robot.home.q)
        self.height = top_of(self._body, shapes)
        scene.add_label(
            f"{root}/label",
            label.title,
            position=(0.0, 0.0, 1.08 * self.height),
            anchor="bottom-center",
        )

    def place(self, y: float) -> None:
        """Put it into the row [m]."""
        self._root.position = (0.0, y, 0.0)

    def show(self, run: ShownRun, choice: ViewChoice) -> None:
        """Show the newest tick of its run, if there is one."""
        ticks = run.ticks
        if not len(ticks):
            return
        q = ticks.true_q[-1] if np.isfinite(ticks.true_q[-1]).all() else ticks.q[-1]
        if not np.isfinite(q).all():
            return
        self._body.show(q)
        self._body.see_through(choice.see_through)
        self._contacts.show_parts(forces=choice.forces, support=choice.support)
        self._contacts.show(self._body.data, ticks.wrenches[-1])
        self._show_ghost(q, ticks.all_errors[-1], choice.ghost)
        self._mass.visible = choice.mass
        self._mass.show(ticks)

    def _show_ghost(self, q: Vector, errors: Vector, wanted: bool) -> None:
        known = bool(np.isfinite(errors).all())
        self._ghost.visible = wanted and known
        if wanted and known:
            named = dict(zip(self._axes, map(float, errors), strict=True))
            self._ghost.show(ghost_posture(self._robot, unit(q), named, self._moved))

    def remove(self) -> None:
        """Take everything away."""
        self._root.remove()


def top_of(body: RobotBody, shapes: list[Shape]) -> float:
    """Tell how tall a body is as it stands [m]."""
    tops = [
        (shape.vertices @ place.rotation[2] + place.translation[2]).max()
        for shape in shapes
        for place in (body.data.oMi[shape.joint],)
    ]
    return float(max(tops, default=1.0))
