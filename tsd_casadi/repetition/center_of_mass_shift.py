r"""A repetition with the corrected centre of mass.

.. math:: x_{ref} + \big( c_{model}(q) - c(q) \big) - c_{model}(q) = x_{ref} - c(q)

The controller goes on with its own model and, since its reference is shifted,
sees the error of the corrected centre of mass.
"""

from __future__ import annotations

from tsd_casadi.center_of_mass.correction import CenterOfMassCorrection
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting


class CenterOfMassShift(Compensator):
    """Shifts the reference by the model's error of the centre of mass."""

    def __init__(self, correction: CenterOfMassCorrection) -> None:
        """Use a correction.

        Args:
            correction: Of the robot that will move.
        """
        self._correction = correction
        self.correction = correction.fingerprint

    def start(self, setting: Setting) -> None:
        """Refuse another robot's correction, or a task that is no centre of mass.

        Raises:
            InvalidValue: If correction and repetition do not belong together.
        """
        corrected, robot = self._correction.robot, setting.robot
        if corrected.fingerprint != robot.fingerprint:
            raise InvalidValue(
                "robot of the centre of mass' correction",
                f"{corrected.name} ({corrected.fingerprint})",
                f"{robot.name} ({robot.fingerprint})",
            )
        if not any(task.type == "com" for task in robot.description.tasks):
            raise InvalidValue("tasks", "none of the centre of mass", "one that can be corrected")

    def before(self, moment: Moment) -> None:
        """Shift position and velocity."""
        q, v = moment.state.q, moment.state.v
        moment.shift -= self._correction.offset(q)
        moment.shift_rate -= self._correction.offset_rate(q, v)
