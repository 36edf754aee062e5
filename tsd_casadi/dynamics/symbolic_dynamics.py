"""Rigid-body dynamics and kinematics of a robot as CasADi expressions [dynamics]."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from pinocchio_casadi import SymbolicModel
from tsd_casadi.dynamics.rotation import rotation_matrix
from tsd_casadi.robot.robot import Robot


@dataclass(frozen=True)
class PointKinematics:
    r"""Kinematics of a centre of mass, :math:`\ddot c = J \ddot q + \dot J \dot q`.

    Attributes:
        position: c, (3,) [m], world frame.
        J: (3, nv), world frame.
        drift: dJ/dt v, (3,) [m/s^2], world frame.
    """

    position: ca.SX
    J: ca.SX
    drift: ca.SX


@dataclass(frozen=True)
class FrameKinematics:
    """Kinematics of a frame.

    Attributes:
        position: (3,) [m], world frame.
        R: Rotation from the frame to the world, (3, 3).
        J: (6, nv), rows [linear; angular], in the axes asked for.
        drift: Classical acceleration at zero joint acceleration, (6,)
            [m/s^2, rad/s^2], in the same axes.
    """

    position: ca.SX
    R: ca.SX
    J: ca.SX
    drift: ca.SX


class SymbolicDynamics:
    r"""The terms of :math:`M \ddot q + h = S^T \tau + J_c^T \lambda` [dynamics].

    Attributes:
        q: Configuration symbols as given, (nq,).
        v: Velocity symbols as given, (nv,).
        n: Number of actuated joints.
        nv: Size of v.
    """

    def __init__(self, robot: Robot, q: ca.SX, v: ca.SX) -> None:
        """Take a robot and the symbols of its state.

        The base quaternion is normalised first, so that the 1e-16 by which a
        simulator's quaternion is off does not grow.

        Args:
            q: (nq,) symbols.
            v: (nv,) symbols.
        """
        self._model = SymbolicModel(robot.model)
        quaternion = q[3:7]
        self.q = ca.vertcat(q[:3], quaternion / ca.norm_2(quaternion), q[7:])
        self.v = v
        self.n = robot.n
        self.nv = robot.nv

    def mass_matrix(self) -> ca.SX:
        """Compute the joint-space inertia M, (nv, nv) [kg, kg m, kg m^2]."""
        return self._model.mass_matrix()(self.q)

    def bias_forces(self) -> ca.SX:
        """Compute Coriolis, centrifugal and gravity forces h, (nv,) [N, N m]."""
        return self._model.bias_forces()(self.q, self.v)

    def gravity_forces(self) -> ca.SX:
        """Compute the gravity forces, h at rest, (nv,) [N, N m]."""
        return self._model.bias_forces()(self.q, ca.SX.zeros(self.nv))

    def base_rotation(self) -> ca.SX:
        """Compute the rotation from the base frame to the world, (3, 3)."""
        return rotation_matrix(self.q[3:7])

    def center_of_mass(self) -> PointKinematics:
        """Compute the kinematics of the centre of mass, world frame."""
        return PointKinematics(*self._model.center_of_mass()(self.q, self.v))

    def frame(self, name: str, *, local: bool) -> FrameKinematics:
        """Compute the kinematics of a frame of the robot.

        Args:
            local: Jacobian and drift in the frame's own axes if true, in axes
                parallel to the world's otherwise.
        """
        return FrameKinematics(*self._model.frame(name, local=local)(self.q, self.v))
