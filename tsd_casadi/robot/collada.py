"""Which way a COLLADA mesh of a link is turned.

Its ``up_axis`` is obeyed by some programs and not by others, and descriptions are
written for either: the loader that we use gives plain vertices. With a mesh whose
y axis is up we take the reading that is nearer to the link's own centre of mass.
"""

from __future__ import annotations

import re
from functools import cache
from typing import Any

import numpy as np

from tsd_casadi.state import Matrix, Vector

# the tag is in the first element of a file
HEAD = 20_000
# y up to z up
TURN = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])


def turn_of(model: Any, part: Any, vertices: Matrix) -> Matrix:
    """Compute the rotation that a mesh needs before it is placed on its link.

    Args:
        model: ``pinocchio.Model``.
        part: ``pinocchio.GeometryObject``.
        vertices: In the mesh's frame, (k, 3).

    Returns:
        (3, 3); identity unless the mesh says that y is up and fits the link better turned.
    """
    if not _says_y_up(part.meshPath):
        return np.eye(3)
    frame = model.frames[part.parentFrame]
    # a link that is fixed to another has its own inertia, else the joint's body is the link
    com: Vector = (
        frame.placement.act(np.array(frame.inertia.lever))
        if frame.inertia.mass > 0
        else np.array(model.inertias[frame.parentJoint].lever)
    )
    wanted = part.placement.actInv(com)
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    plain, turned = (float(np.linalg.norm(R @ middle - wanted)) for R in (np.eye(3), TURN))
    return TURN if turned < plain else np.eye(3)


@cache
def _says_y_up(path: str) -> bool:
    if not path.lower().endswith(".dae"):
        return False
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return re.search(r"<up_axis>\s*Y_UP", file.read(HEAD)) is not None
    except OSError:
        return False
