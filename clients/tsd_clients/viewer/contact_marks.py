"""What the ground does to a robot, in the 3D view."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from tsd_casadi.robot.convex_polygon import hull
from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import PointFile
from tsd_casadi.state import Matrix, Vector
from tsd_clients.viewer import primitives

# of its weight: a foot that presses less is off the ground, whatever a solver's last digits say
LEAST_PRESSURE = 0.005
FORCE, ON, OFF, SUPPORT, PRESSURE = (
    (226, 100, 20),
    (43, 138, 62),
    (150, 155, 160),
    (43, 138, 62),
    (226, 60, 60),
)
# above the ground, on top of one another [m]
ABOVE = 0.002
POINT = 0.02  # radius of the mark of a point [m]


class ContactMarks:
    """Wrenches as arrows, feet that are on, the support polygon, the centre of pressure.

    Attributes:
        feet_on: Names of the contacts that press on the ground.
    """

    def __init__(self, scene: viser.SceneApi, root: str, robot: Robot) -> None:
        """Add the marks.

        Args:
            root: Name of the node that they hang on.
        """
        self._robot = robot
        self.feet_on: tuple[str, ...] = ()
        # half of the weight, a foot's share, reaches as high as the centre of mass: past
        # the shins in which shorter arrows would hide
        self._scale = 2.0 * float(robot.home_com[2]) / robot.weight
        size = float(robot.home_com[2])
        self._forces_root = scene.add_frame(f"{root}/forces", show_axes=False)
        self._arrows = scene.add_arrows(
            f"{root}/forces/arrows",
            np.zeros((len(robot.feet), 2, 3)),
            FORCE,
            shaft_radius=0.018 * size,
            head_radius=0.045 * size,
            head_length=0.1 * size,
        )
        self._support_root = scene.add_frame(f"{root}/support", show_axes=False)
        self._polygon = scene.add_line_segments(
            f"{root}/support/polygon", np.zeros((1, 2, 3)), SUPPORT, thickness=0.006
        )
        self._pressure = scene.add_icosphere(
            f"{root}/support/pressure", 0.018, PRESSURE, subdivisions=2, cast_shadow=False
        )
        self._soles = [
            tuple(
                scene.add_mesh_simple(
                    f"{root}/support/{foot.name}{word}",
                    *_patch(foot, isinstance(contact, PointFile)),
                    color=color,
                    opacity=0.6,
                    side="double",
                    cast_shadow=False,
                    receive_shadow=False,
                )
                for word, color in (("on", ON), ("off", OFF))
            )
            for foot, contact in zip(robot.feet, robot.description.contacts, strict=True)
        ]

    def show_parts(self, *, forces: bool, support: bool) -> None:
        """Choose what is seen."""
        self._forces_root.visible, self._support_root.visible = forces, support

    def show(self, data: Any, wrenches: Matrix) -> None:
        """Show the contacts of one tick.

        Args:
            data: ``pinocchio.Data`` with the frames' placements.
            wrenches: [force; moment], (c, 6) [N, N m]; NaN where there is no answer.
        """
        forces, places, corners, names = [], [], [], []
        arrows = np.zeros((len(wrenches), 2, 3))
        for number, (foot, wrench) in enumerate(zip(self._robot.feet, wrenches, strict=True)):
            place = data.oMf[foot.frame]
            force, pressed = _pressed(foot, place, wrench)
            on = bool(force[2] > LEAST_PRESSURE * self._robot.weight)
            self._mark_sole(number, place, on)
            arrows[number] = pressed
            if on:
                arrows[number, 1] += self._scale * force
                forces.append(force[2])
                places.append(pressed)
                corners.append(foot.corners(place))
                names.append(foot.name)
        self.feet_on = tuple(names)
        self._arrows.points = arrows.astype(np.float32)
        self._pressure.visible = self._polygon.visible = bool(names)
        if names:
            self._pressure.position = np.average(places, axis=0, weights=forces)
            self._polygon.points = _outline(np.vstack(corners)).astype(np.float32)

    def _mark_sole(self, number: int, place: Any, on: bool) -> None:
        for shown, mark in zip((on, not on), self._soles[number], strict=True):
            mark.visible = shown
            mark.position = place.translation
            mark.wxyz = viser.transforms.SO3.from_matrix(place.rotation).wxyz


def _pressed(foot: Any, place: Any, wrench: Vector) -> tuple[Vector, Vector]:
    """Compute force and centre of pressure of a foot, world frame."""
    wrench = np.nan_to_num(wrench)
    if foot.rows == 3:
        return wrench[:3], np.array(place.translation)
    fx, fy, fz, mx, my, _ = wrench
    inside = np.array((-my / fz, mx / fz, 0.0)) if fz > 1.0 else np.zeros(3)
    return place.rotation @ np.array((fx, fy, fz)), np.array(place.act(inside))


def _outline(corners: Matrix) -> Matrix:
    """Draw the hull of points on the ground, (segments, 2, 3)."""
    flat = hull(corners[:, :2]) if len(corners) > 2 else corners[:, :2]
    ring = np.column_stack((flat, np.full(len(flat), 2 * ABOVE)))
    return np.stack((ring, np.roll(ring, -1, axis=0)), axis=1)


def _patch(foot: Any, point: bool) -> tuple[Matrix, Matrix]:
    import pinocchio

    if point:
        vertices, faces = primitives.ellipsoid(np.full(3, POINT))
    else:
        low, *_, high = foot.corners(pinocchio.SE3.Identity())
        half = np.array((*(high - low)[:2] / 2, ABOVE / 2))
        vertices, faces = primitives.box(half)
        vertices = vertices + np.array((*(high + low)[:2] / 2, ABOVE))
    return vertices.astype(np.float32), faces.astype(np.uint32)
