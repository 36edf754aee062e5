"""The centre of mass, corrected, with how sure that is."""

from __future__ import annotations

import hashlib
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio

from tsd_casadi.center_of_mass.correction_file import CenterOfMassMessage
from tsd_casadi.center_of_mass.static_chain import StaticChain
from tsd_casadi.document import to_matrix
from tsd_casadi.exceptions import InvalidValue, MalformedMessage
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Matrix, Vector
from tsd_casadi.whole_file import write_whole

# of a covariance's largest eigenvalue: what rounding may do to the smallest
ROUNDING = 1e-9


class CenterOfMassCorrection:
    """A robot's centre of mass with other chain vectors than its model's.

    Attributes:
        robot: The robot.
        terms: r_i, (N, 3) [m], in the links' frames.
        covariance: Of ``terms`` as one vector, (3 N, 3 N) [m^2].
    """

    def __init__(self, robot: Robot, terms: Matrix, covariance: Matrix) -> None:
        """Prepare the kinematics.

        Args:
            terms: r_i, (N, 3) [m].
            covariance: Of them, (3 N, 3 N) [m^2].

        Raises:
            InvalidValue: If the robot has no chain, a shape does not fit, or the
                covariance is none.
        """
        self.robot = robot
        self._chain = StaticChain(robot)
        size = 3 * len(self._chain.links)
        for name, value, shape in (
            ("terms", terms, (size // 3, 3)),
            ("covariance", covariance, (size, size)),
        ):
            if np.shape(value) != shape or not np.isfinite(value).all():
                raise InvalidValue(name, f"of shape {np.shape(value)}", f"numbers, shape {shape}")
        self.terms = np.array(terms, dtype=float)
        self.covariance = np.array(covariance, dtype=float)
        least, most = np.linalg.eigvalsh(self.covariance)[[0, -1]]
        symmetric = np.allclose(self.covariance, self.covariance.T, rtol=0, atol=ROUNDING * most)
        if least < -ROUNDING * most or not symmetric:
            raise InvalidValue("covariance", "none", "a symmetric matrix without negative variance")
        self._corrected = self._chain.model_with(self.terms)
        self._corrected_data = self._corrected.createData()
        self._model, self._data = robot.model, robot.model.createData()

    @cached_property
    def fingerprint(self) -> str:
        """Hash of the terms: what was learned with one correction is not that of another."""
        return hashlib.sha256(np.round(self.terms, 12).tobytes()).hexdigest()[:16]

    def center_of_mass(self, q: Vector) -> Vector:
        """Compute the corrected centre of mass of a configuration, (3,) [m], world frame.

        Args:
            q: Configuration, (nq,).
        """
        return np.array(pinocchio.centerOfMass(self._corrected, self._corrected_data, q))

    def offset(self, q: Vector) -> Vector:
        """Compute corrected minus the model's centre of mass, (3,) [m], world frame.

        Args:
            q: Configuration, (nq,).
        """
        model = pinocchio.centerOfMass(self._model, self._data, q)
        return np.asarray(self.center_of_mass(q) - model)

    def offset_rate(self, q: Vector, v: Vector) -> Vector:
        """Compute the time derivative of ``offset``, (3,) [m/s], world frame.

        Args:
            q: Configuration, (nq,).
            v: Velocity, (nv,).
        """
        pinocchio.centerOfMass(self._corrected, self._corrected_data, q, v)
        pinocchio.centerOfMass(self._model, self._data, q, v)
        return np.asarray(self._corrected_data.vcom[0] - self._data.vcom[0])

    def deviation(self, q: Vector) -> Vector:
        """Compute the corrected centre of mass' standard deviation, (3,) [m], world axes.

        Args:
            q: Configuration, (nq,).
        """
        F = self._chain.features(q)
        variances = np.einsum("ij,jk,ik->i", F, self.covariance, F)
        return np.asarray(np.sqrt(np.maximum(variances, 0.0)))

    def message(self) -> CenterOfMassMessage:
        """Write the correction as plain data."""
        return CenterOfMassMessage(
            robot=self.robot.name,
            fingerprint=self.robot.fingerprint,
            links=self._chain.links,
            terms=self.terms.tolist(),
            covariance=self.covariance.tolist(),
        )

    def save(self, path: Path) -> None:
        """Write the correction as JSON, whole or not at all."""
        with write_whole(path) as file:
            file.write(self.message().encode())

    @classmethod
    def load(cls, robot: Robot, path: Path) -> CenterOfMassCorrection:
        """Read a robot's correction from a file.

        Raises:
            MalformedMessage: If the file is none.
            InvalidValue: If it is of another robot or model.
        """
        try:
            message = CenterOfMassMessage.decode(path.read_bytes())
        except OSError as error:
            raise MalformedMessage(
                f"{path} cannot be read ({error.strerror})", "a file of 'tsd calibrate'"
            ) from error
        except MalformedMessage as error:
            raise MalformedMessage(f"{path}: {error}", "a file of 'tsd calibrate'") from error
        return cls.from_message(robot, message)

    @classmethod
    def from_message(cls, robot: Robot, message: CenterOfMassMessage) -> CenterOfMassCorrection:
        """Take a robot's correction from plain data.

        Raises:
            MalformedMessage: If its vectors and covariance do not belong together.
            InvalidValue: If it is of another robot or model.
        """
        for name, found, expected in (
            ("robot", message.robot, robot.name),
            ("fingerprint", message.fingerprint, robot.fingerprint),
            ("links", message.links, StaticChain(robot).links),
        ):
            if found != expected:
                raise InvalidValue(
                    f"{name} of the centre of mass' correction",
                    repr(found),
                    f"{expected!r}; run 'tsd calibrate' again for this robot",
                )
        size = 3 * len(message.links)
        terms = to_matrix("terms", message.terms, (len(message.links), 3))
        return cls(robot, terms, to_matrix("covariance", message.covariance, (size, size)))
