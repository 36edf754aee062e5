"""Arrows drawn over a picture: what is inside of a leg would not be seen."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.state import Matrix, Vector
from tsd_clients.film.video_file import Picture

COLOR = (20, 140, 60)
SHAFT, HEAD = 0.008, 0.025  # of the picture's height
SHORTEST = 1.0  # of the head's length: what is shorter is no arrow


def project(scene: Any, points: Matrix, width: int, height: int) -> Matrix:
    """Tell where points are in a picture.

    Args:
        scene: ``mujoco.MjvScene`` of the picture.
        points: (..., 3) [m], world frame, in front of the camera.
        width: Of the picture [pixels].
        height: Of the picture [pixels].

    Returns:
        (..., 2) [pixels], from the left and from the top.
    """
    # a scene has a camera for each eye; a picture is taken from between them
    left, camera = scene.camera[0], scene.camera[1]
    forward, up = np.array(camera.forward), np.array(camera.up)
    seen = points - 0.5 * (np.array(left.pos) + np.array(camera.pos))
    depth = seen @ forward
    # MuJoCo's frustum is as high as is said, and as wide as the picture's shape wants
    middle = 0.5 * (camera.frustum_top + camera.frustum_bottom)
    scale = height / (camera.frustum_top - camera.frustum_bottom)
    near = camera.frustum_near / depth
    right = np.cross(forward, up)
    x = 0.5 * width + scale * near * (seen @ right)
    y = 0.5 * height - scale * (near * (seen @ up) - middle)
    return np.stack((x, y), axis=-1)


def draw_arrows(picture: Picture, arrows: Matrix) -> Picture:
    """Draw arrows.

    Args:
        picture: (height, width, 3).
        arrows: Foot and tip of each, (c, 2, 2) [pixels].

    Returns:
        The picture with them.
    """
    from PIL import Image, ImageDraw

    image = Image.fromarray(picture)
    draw = ImageDraw.Draw(image)
    shaft, head = SHAFT * image.height, HEAD * image.height
    for start, tip in arrows:
        length = float(np.linalg.norm(tip - start))
        if not length > SHORTEST * head:
            continue
        along = (tip - start) / length
        aside = np.array([-along[1], along[0]])
        neck = tip - head * along
        draw.polygon(_corners(start, neck, 0.5 * shaft * aside), fill=COLOR)
        wings = [tip, neck + 0.5 * head * aside, neck - 0.5 * head * aside]
        draw.polygon([tuple(map(float, corner)) for corner in wings], fill=COLOR)
    return np.asarray(image)


def _corners(start: Vector, end: Vector, aside: Vector) -> list[tuple[float, ...]]:
    corners: list[NDArray[np.float64]] = [start + aside, end + aside, end - aside, start - aside]
    return [tuple(map(float, corner)) for corner in corners]
