"""The Jacobian of a robot's contacts, in numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, Vector


def contact_jacobian(robot: Robot, data: Any, q: Vector) -> Matrix:
    """Compute J_c of all contacts of a robot.

    Args:
        data: ``pinocchio.Data`` of the robot's model, changed.
        q: Configuration, (nq,).

    Returns:
        Six rows of a sole, three of a point, which carries no moment; world axes.
    """
    model = robot.model
    pinocchio.computeJointJacobians(model, data, q)
    contacts = zip(robot.sole_frames, robot.description.contacts, strict=True)
    return np.concatenate(
        [
            pinocchio.getFrameJacobian(
                model, data, frame, pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )[: 3 if part.type == "point" else 6]
            for frame, part in contacts
        ]
    )
