"""Joint friction, identified, as a feedforward of torques."""

from __future__ import annotations

import numpy as np
import pinocchio

from tsd_casadi.identification.observations import Friction
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.robot.robot_file_sections import FRAME_AXES
from tsd_casadi.robot.robot_file_tasks import ComTaskFile
from tsd_casadi.state import Matrix, Vector


class FrictionFeedforward(Compensator):
    r"""Adds the torque that the joints' friction will take, from the wanted motion.

    The joint velocities are those that the commanded task velocities ask for,
    feet still: :math:`v = J^+ \dot x_{ref}` over all tasks and contacts.
    Measured ones would turn Coulomb friction into a jump at every zero crossing
    of the noise.
    """

    def __init__(self, friction: Friction) -> None:
        """Take what was identified."""
        self._friction = friction

    def start(self, setting: Setting) -> None:
        """Note the robot."""
        self._robot = setting.robot
        self._data = setting.robot.model.createData()

    def after(self, moment: Moment) -> None:
        """Add the friction."""
        moment.tau = moment.tau + self._friction.torque(self._wanted_velocity(moment)[6:])

    def _wanted_velocity(self, moment: Moment) -> Vector:
        model, data, q = self._robot.model, self._data, moment.state.q
        pinocchio.computeJointJacobians(model, data, q)
        pinocchio.updateFramePlacements(model, data)
        J: list[Matrix] = []
        xd: list[Vector] = []
        for task in self._robot.description.tasks:
            if isinstance(task, ComTaskFile):
                rows = ["xyz".index(axis) for axis in task.axes]
                J_task = pinocchio.jacobianCenterOfMass(model, data, q)
            else:
                rows = [FRAME_AXES.index(axis) for axis in task.axes]
                frame = self._robot.frame_id(task.name)
                J_task = pinocchio.getFrameJacobian(
                    model, data, frame, pinocchio.LOCAL_WORLD_ALIGNED
                )
            J.append(np.array(J_task[rows]))
            xd.append(moment.command[f"{task.name}.reference_velocity"])
        for foot in self._robot.feet:
            J.append(foot.jacobian(model, data))
            xd.append(np.zeros(foot.rows))
        return np.asarray(np.linalg.lstsq(np.vstack(J), np.concatenate(xd), rcond=1e-6)[0])
