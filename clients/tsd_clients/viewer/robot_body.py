"""A robot in the 3D view."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio
import viser

from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector
from tsd_clients.viewer.robot_shapes import Shape

# turns and shifts that nobody sees are not sent
UNSEEN = 1e-5
GHOST = (90, 140, 220)
GHOST_OPACITY = 0.22
SEE_THROUGH = 0.45


class RobotBody:
    """Links that hang on one another as the joints do: what is sent is one turn a joint.

    Attributes:
        data: ``pinocchio.Data`` of the posture that is shown.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        root: str,
        robot: Robot,
        shapes: Sequence[Shape],
        *,
        ghost: bool = False,
    ) -> None:
        """Add the robot.

        Args:
            root: Name of the node that it hangs on.
            ghost: Whether it is seen through.
        """
        model = robot.model
        self._model = model
        self.data: Any = model.createData()
        names = [root]
        for joint in range(1, model.njoints):
            names.append(f"{names[model.parents[joint]]}/{model.names[joint]}")
        self._root = scene.add_frame(f"{root}", show_axes=False)
        self._joints = [
            scene.add_frame(name, show_axes=False, wxyz=(1.0, 0.0, 0.0, 0.0)) for name in names[1:]
        ]
        self._meshes: list[viser.MeshHandle] = []
        self._transparent = False
        for number, shape in enumerate(shapes):
            color = np.array(GHOST if ghost else shape.color) / (255.0 if ghost else 1.0)
            mesh = scene.add_mesh_simple(
                f"{names[shape.joint]}/shape{number}",
                shape.vertices.astype(np.float32),
                shape.faces.astype(np.uint32),
                color=color,
                opacity=GHOST_OPACITY if ghost else None,
                flat_shading=not ghost,
                # a hole that decimation left shows the inside, not what is behind
                side="front" if ghost else "double",
                cast_shadow=not ghost,
                receive_shadow=False,
            )
            self._meshes.append(mesh)

    def show(self, q: Vector) -> None:
        """Show a posture.

        Args:
            q: Configuration, (nq,).
        """
        pinocchio.framesForwardKinematics(self._model, self.data, unit(q))
        for handle, place in zip(self._joints, self.data.liMi.tolist()[1:], strict=True):
            x, y, z, w = pinocchio.Quaternion(place.rotation).coeffs()
            turn, shift = np.array((w, x, y, z)), place.translation
            if np.abs(turn - handle.wxyz).max() > UNSEEN:
                handle.wxyz = turn
            if np.abs(shift - handle.position).max() > UNSEEN:
                handle.position = shift

    def see_through(self, wanted: bool) -> None:
        """Choose whether what is inside is seen."""
        if wanted != self._transparent:
            self._transparent = wanted
            for mesh in self._meshes:
                mesh.opacity = SEE_THROUGH if wanted else None

    @property
    def visible(self) -> bool:
        """Whether it is shown."""
        return bool(self._root.visible)

    @visible.setter
    def visible(self, visible: bool) -> None:
        self._root.visible = visible

    def remove(self) -> None:
        """Take it away."""
        self._root.remove()


def unit(q: Vector) -> Vector:
    """Make the quaternion of a configuration one again: a log has it in 32 bits.

    Args:
        q: (nq,).

    Returns:
        A changed copy, (nq,).
    """
    q = np.array(q, dtype=float)
    q[3:7] /= np.linalg.norm(q[3:7])
    return q
