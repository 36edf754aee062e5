"""What keeps a foot in its place, in numbers: a sole keeps its pose, a point its position."""

from __future__ import annotations

import abc
from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.robot.robot_file_sections import Contact, PointFile
from tsd_casadi.state import Matrix, Vector

UP = np.array([0.0, 0.0, 1.0])


class Foot(abc.ABC):
    """A foot on the ground plane z = 0.

    Attributes:
        name: Name of the contact.
        frame: Pinocchio's index of its frame.
        rows: How many directions it keeps from moving.
    """

    rows: int

    def __init__(self, name: str, frame: int) -> None:
        """Take a contact's name and its frame."""
        self.name = name
        self.frame = frame

    @abc.abstractmethod
    def jacobian(self, model: Any, data: Any) -> Matrix:
        """Read the Jacobian of what the foot keeps, (rows, nv).

        Args:
            data: With joint Jacobians and frame placements computed.
        """

    @abc.abstractmethod
    def error(self, data: Any, place: Any) -> Vector:
        """Compute what is missing from here to a place, (rows,), in the axes of the Jacobian.

        Args:
            data: With frame placements computed.
            place: ``pinocchio.SE3``, world frame.
        """

    @abc.abstractmethod
    def tilt(self, place: Any, normal: Vector = UP) -> float:
        """Tell how far the foot at a place is from lying flat [rad, small angles].

        Args:
            place: ``pinocchio.SE3``, world frame.
            normal: Of the ground, (3,), world frame.
        """

    @abc.abstractmethod
    def normals(self, place: Any) -> Matrix:
        """Tell what a foot at a place alone says of the ground's normal.

        Args:
            place: ``pinocchio.SE3``, world frame.

        Returns:
            (1, 3), world frame, or (0, 3) if it says nothing.
        """

    @abc.abstractmethod
    def upright(self, home: Any) -> Any:
        """Turn the frame about its origin until its z axis is up at home.

        Args:
            home: ``pinocchio.SE3`` of the frame at home, world frame.

        Returns:
            ``pinocchio.SE3``, from the frame to the turned one.
        """

    @abc.abstractmethod
    def corners(self, place: Any) -> Matrix:
        """Compute where the foot at a place may press on the ground.

        Args:
            place: ``pinocchio.SE3``, world frame.

        Returns:
            Points whose hull it is, (c, 3) [m], world frame.
        """


class Sole(Foot):
    """A flat foot, which keeps its pose; sole axes."""

    rows = 6

    def __init__(self, name: str, frame: int, x: Vector, y: Vector) -> None:
        """Take the extents (low, high) along x and y [m], sole frame."""
        super().__init__(name, frame)
        self._corners = np.array([[a, b, 0.0] for a in x for b in y])

    def jacobian(self, model: Any, data: Any) -> Matrix:
        """Read the Jacobian of the pose, sole axes, (6, nv)."""
        return np.array(pinocchio.getFrameJacobian(model, data, self.frame, pinocchio.LOCAL))

    def error(self, data: Any, place: Any) -> Vector:
        """Compute the twist from here to a place, sole axes, (6,)."""
        return np.array(pinocchio.log6(data.oMf[self.frame].actInv(place)).vector)

    def tilt(self, place: Any, normal: Vector = UP) -> float:
        """Tell how far the sole's normal is from the ground's."""
        return float(np.linalg.norm(place.rotation[:, 2] - normal))

    def normals(self, place: Any) -> Matrix:
        """Give the sole's normal, (1, 3), world frame."""
        return np.array([place.rotation[:, 2]])

    def upright(self, home: Any) -> Any:
        """Leave the frame as it is: a sole's is upright."""
        return pinocchio.SE3.Identity()

    def corners(self, place: Any) -> Matrix:
        """Compute where the sole's corners are, (4, 3) [m], world frame."""
        return np.array([place.act(corner) for corner in self._corners])


class Point(Foot):
    """A foot that touches in a point and may turn about it; world axes."""

    rows = 3

    def jacobian(self, model: Any, data: Any) -> Matrix:
        """Read the Jacobian of the position, world axes, (3, nv)."""
        aligned = pinocchio.LOCAL_WORLD_ALIGNED
        return np.array(pinocchio.getFrameJacobian(model, data, self.frame, aligned)[:3])

    def error(self, data: Any, place: Any) -> Vector:
        """Compute the way from here to a place, world axes, (3,)."""
        return np.array(place.translation - data.oMf[self.frame].translation)

    def tilt(self, place: Any, normal: Vector = UP) -> float:
        """Tell that a point lies on the ground however its link is turned."""
        return 0.0

    def normals(self, place: Any) -> Matrix:
        """Give none, (0, 3): a point touches any ground."""
        return np.empty((0, 3))

    def upright(self, home: Any) -> Any:
        """Turn it into the world's axes."""
        return pinocchio.SE3(home.rotation.T, np.zeros(3))

    def corners(self, place: Any) -> Matrix:
        """Give the point itself, (1, 3) [m], world frame."""
        return np.array([place.translation])


def make_foot(contact: Contact, frame: int) -> Foot:
    """Make the foot of a contact of the robot file.

    Args:
        frame: Pinocchio's index of its frame.
    """
    if isinstance(contact, PointFile):
        return Point(contact.name, frame)
    return Sole(contact.name, frame, np.array(contact.x), np.array(contact.y))


def feet_jacobian(feet: Sequence[Foot], model: Any, data: Any, q: Vector) -> Matrix:
    """Stack the Jacobians of some feet.

    Args:
        q: Configuration, (nq,).

    Returns:
        (rows of all feet, nv); ``data`` has joint Jacobians and frame placements then.
    """
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.updateFramePlacements(model, data)
    return np.vstack([foot.jacobian(model, data) for foot in feet])
