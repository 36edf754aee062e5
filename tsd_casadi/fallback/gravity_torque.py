r"""Gravity compensation of a standing robot, in numbers.

.. math::

    \tau_g = g_a - J_{c,a}^T \lambda_g, \qquad
    \lambda_g = \arg\min \|\lambda\|^2 \;\text{s.t.}\; J_{c,u}^T \lambda = g_u

The compiled controller's safe torque is the same with damping within the limits
(``tsd_casadi.formulation.safe_torque``); this one is for whoever has lost the
controller and knows the robot's files.
"""

from __future__ import annotations

import numpy as np
import pinocchio

from tsd_casadi.fallback.contact_jacobian import contact_jacobian
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector

# as in the safe torque: of a 6 x 6 Gram matrix whose entries are of the order of one
DAMPING = 1e-6


class GravityTorque:
    """Gravity compensation of a robot that stands on all of its contacts."""

    def __init__(self, robot: Robot) -> None:
        """Prepare for one robot; one instance serves one thread."""
        self._robot, self._data = robot, robot.model.createData()

    def __call__(self, q: Vector) -> Vector:
        """Compute the torque.

        Args:
            q: Configuration, (nq,).

        Returns:
            (n,) [N m], without any limit.
        """
        gravity = pinocchio.computeGeneralizedGravity(self._robot.model, self._data, q)
        J = contact_jacobian(self._robot, self._data, q)
        J_u = J[:, :6]
        forces = J_u @ np.linalg.solve(J_u.T @ J_u + DAMPING * np.eye(6), gravity[:6])
        return np.asarray(gravity[6:] - J[:, 6:].T @ forces)
