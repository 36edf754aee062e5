"""Where the centre of mass is, was thought to be and should be, in the 3D view."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import viser

from tsd_casadi.robot.robot import Robot
from tsd_clients.viewer.robot_body import unit
from tsd_clients.viewer.ticks import Ticks

ESTIMATED, TRUE, REFERENCE = (40, 90, 200), (20, 20, 20), (240, 170, 0)
RADIUS = 0.022  # m
ABOVE_GROUND = 0.004  # m
AXES = ("x", "y", "z")


class MassMarks:
    """Balls at the estimated, the true and the wanted centre of mass, with their plumb lines."""

    def __init__(
        self,
        scene: viser.SceneApi,
        root: str,
        robot: Robot,
        all_axes: Sequence[tuple[str, str]],
        axes: Sequence[str],
    ) -> None:
        """Add the marks.

        Args:
            root: Name of the node that they hang on.
            all_axes: (task, axis) in the order of all errors.
            axes: 'task.axis' of the repetition.
        """
        self._robot = robot
        tasks = [task.name for task in robot.description.all_tasks if task.type == "com"]
        names = [f"{tasks[0]}.{axis}" for axis in AXES] if tasks else []
        told = [".".join(pair) for pair in all_axes]
        # (component, its place)
        self._errors = [(i, told.index(n)) for i, n in enumerate(names) if n in told]
        self._true_errors = [(i, list(axes).index(n)) for i, n in enumerate(names) if n in axes]
        self._root = scene.add_frame(f"{root}/mass", show_axes=False)
        self._balls = {
            name: scene.add_icosphere(
                f"{root}/mass/{name}", size * RADIUS, color, subdivisions=2, cast_shadow=False
            )
            # where they are at one place, the smaller one is seen inside of none
            for name, color, size in (
                ("reference", REFERENCE, 0.8),
                ("true", TRUE, 0.9),
                ("estimated", ESTIMATED, 1.0),
            )
        }
        self._plumb = scene.add_line_segments(
            f"{root}/mass/plumb", np.zeros((1, 2, 3)), ESTIMATED, thickness=0.004
        )

    @property
    def visible(self) -> bool:
        """Whether they are shown."""
        return bool(self._root.visible)

    @visible.setter
    def visible(self, visible: bool) -> None:
        self._root.visible = visible

    def show(self, ticks: Ticks) -> None:
        """Show the newest tick's."""
        estimated = self._robot.center_of_mass(unit(ticks.q[-1]))
        reference = estimated.copy()
        for component, place in self._errors:
            reference[component] += np.nan_to_num(ticks.all_errors[-1, place])
        true = estimated.copy()
        known = bool(np.isfinite(ticks.true_q[-1]).all())
        if known:
            true = self._robot.center_of_mass(unit(ticks.true_q[-1]))
            # the plant's own masses: its error tells what the controller's model cannot
            for component, axis in self._true_errors:
                error = ticks.true_error[-1, axis]
                if np.isfinite(error):
                    true[component] = reference[component] - error
        self._balls["true"].visible = known
        for name, com in (("estimated", estimated), ("reference", reference), ("true", true)):
            self._balls[name].position = com
        ground = np.array((*estimated[:2], ABOVE_GROUND))
        self._plumb.points = np.array([[estimated, ground]], dtype=np.float32)
