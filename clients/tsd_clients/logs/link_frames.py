"""Where a robot's links and contacts are, as frames in the world."""

from __future__ import annotations

import numpy as np
import pinocchio

from tsd_casadi.robot.robot import Robot
from tsd_casadi.robot.robot_file_sections import PointFile
from tsd_casadi.state import Matrix, Vector

CONTACT = "contact"


class LinkFrames:
    """The frames of all links, and one for each contact's wrench.

    Attributes:
        names: Of the links as in the description, and 'contact/NAME'.
    """

    def __init__(self, robot: Robot) -> None:
        """List the frames."""
        self._model, self._data = robot.model, robot.model.createData()
        links = [
            (str(frame.name), index)
            for index, frame in enumerate(robot.model.frames)
            if frame.type == pinocchio.FrameType.BODY
        ]
        contacts = robot.description.contacts
        self.names = [
            *(name for name, _ in links),
            *(contact_frame(contact.name) for contact in contacts),
        ]
        self._frames = [*(index for _, index in links), *robot.sole_frames]
        # the wrench of a point is in world axes
        self._upright = [False] * len(links) + [isinstance(each, PointFile) for each in contacts]

    def placements(self, q: Vector) -> Matrix:
        """Compute where they are.

        Args:
            q: (nq,).

        Returns:
            Position [m] and quaternion xyzw in the world, (number of names, 7).
        """
        pinocchio.framesForwardKinematics(self._model, self._data, q)
        found = np.empty((len(self._frames), 7))
        for row, frame, upright in zip(found, self._frames, self._upright, strict=True):
            row[:] = pinocchio.SE3ToXYZQUAT(self._data.oMf[frame])
            if upright:
                row[3:] = 0.0, 0.0, 0.0, 1.0
        return found


def contact_frame(contact: str) -> str:
    """Name the frame of a contact's wrench."""
    return f"{CONTACT}/{contact}"
