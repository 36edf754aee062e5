"""How the base is turned where the robot stands upright, facing along the world's x axis."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.exceptions import RobotFileError
from tsd_casadi.state import Matrix, Vector

# an axis of the base this near to the line from the feet to the centre of mass is up: legs
# at their zero may be bent, and arms point forward (cosine of 30 degrees)
NEAR = 0.866


def find_upright(path: Path, model: Any, feet: tuple[int, int]) -> Matrix:
    """Find the rotation of the base, (3, 3).

    The axis of the base next to the line from between the feet to the centre of mass
    is up, if one is within 30 degrees, else that line; left is from the right foot to
    the left one.

    Args:
        path: The description, for errors.
        model: ``pinocchio.Model`` with a free-flyer.
        feet: Indices of the frames of the left and of the right foot.

    Raises:
        RobotFileError: If the feet are in one place.
    """
    data = model.createData()
    q = pinocchio.neutral(model)
    pinocchio.framesForwardKinematics(model, data, q)
    com = np.array(pinocchio.centerOfMass(model, data, q))
    left, right = (np.array(data.oMf[frame].translation) for frame in feet)
    apart = float(np.linalg.norm(left - right))
    names = [model.frames[frame].name for frame in feet]
    if apart < 1e-3:
        raise RobotFileError(
            path, "feet", f"{names[0]} and {names[1]} are in one place", "a left and a right foot"
        )
    up = _snapped(com - 0.5 * (left + right))
    sideways = left - right
    y = _snapped(sideways - (sideways @ up) * up)
    y -= (y @ up) * up
    y /= np.linalg.norm(y)
    # its rows are the world's axes as the base has them
    return np.vstack((np.cross(y, up), y, up))


def _snapped(direction: Vector) -> Vector:
    direction = direction / np.linalg.norm(direction)
    axes = np.vstack((np.eye(3), -np.eye(3)))
    nearest: Vector = axes[int(np.argmax(axes @ direction))]
    return nearest if nearest @ direction > NEAR else direction
