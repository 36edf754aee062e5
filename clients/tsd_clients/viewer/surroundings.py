"""Ground, light and camera of the 3D view."""

from __future__ import annotations

import numpy as np
import viser

# of two robots side by side [m]
APART = 1.3
# where a robot is seen from, relative to where it is looked at: from in front, a little left
# and above
VIEW = np.array((0.84, 0.50, 0.2))
# a row of them from nearly in front: none hides another
ROW_VIEW = np.array((0.97, 0.1, 0.2))
# a narrow field shows a robot as a photographer would [rad]; so many of its heights away
# it fits into a window beside the charts
FIELD = np.radians(35.0)
AWAY = 2.1
# as many times as far away as a row is wide it fits, its nearer end too
ROW_AWAY = 1.6


class Surroundings:
    """What is there without any robot."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Add ground and light."""
        self._server = server
        scene = server.scene
        scene.set_up_direction("+z")
        # reflections of a room cost a browser without a graphics card most of its time
        scene.configure_environment_map(hdri=None)
        scene.configure_default_lights(cast_shadow=False)
        scene.add_light_hemisphere(
            "/light", sky_color=(255, 255, 255), ground_color=(150, 155, 165), intensity=1.6
        )
        scene.add_grid(
            "/ground",
            width=60.0,
            height=60.0,
            cell_size=0.25,
            section_size=1.0,
            cell_color=(222, 226, 230),
            section_color=(190, 196, 203),
            plane_color=(244, 246, 248),
            plane_opacity=1.0,
            position=(0.0, 0.0, -0.002),
        )
        # the ground has no edge
        scene.configure_fog(near=9.0, far=22.0, color=(255, 255, 255))
        self.look_at(1, 1.0)

    def cast_shadows(self, wanted: bool) -> None:
        """Choose whether robots throw shadows."""
        self._server.scene.configure_default_lights(cast_shadow=wanted)

    def look_at(self, robots: int, height: float) -> None:
        """Turn the cameras of all who look to a row of robots.

        Args:
            robots: How many.
            height: Of the tallest one [m].
        """
        target = np.array((0.0, 0.0, 0.5 * height))
        view = VIEW if robots == 1 else ROW_VIEW
        away = max(AWAY * height, ROW_AWAY * APART * robots)
        position = target + away * view / np.linalg.norm(view)
        camera = self._server.initial_camera
        camera.look_at, camera.position, camera.fov = target, position, FIELD
        for client in self._server.get_clients().values():
            with client.atomic():
                client.camera.fov = FIELD
                client.camera.position = position
                client.camera.look_at = target
