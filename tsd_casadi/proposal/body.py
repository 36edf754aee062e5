"""The robot that a file is proposed for: its model with soles, legs and trunk."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio

from tsd_casadi.proposal.legs import Leg, find_legs, find_pelvis, find_trunk
from tsd_casadi.robot.sole_patch import SolePatch
from tsd_casadi.state import Matrix, Vector

# a trunk's rotation about a world axis is controlled apart from the pelvis' if joints in
# between turn about it, to 26 degrees
TURNED_BY_JOINTS = 0.9


@dataclass(frozen=True, eq=False)
class Body:
    """A robot with two soles.

    Attributes:
        model: ``pinocchio.Model``, locked joints merged away, with a frame for each sole.
        upright: Rotation of the base where the robot stands upright facing along x, (3, 3).
        soles: Patch of the left and of the right foot.
        sole_frames: Their indices in the model.
        limit: Bound of each joint's torque, (n,) [N m].
    """

    model: Any
    upright: Matrix
    soles: tuple[SolePatch, SolePatch]
    sole_frames: tuple[int, int]
    limit: Vector = field(repr=False)

    @property
    def n(self) -> int:
        """Number of actuated joints."""
        return int(self.model.nv) - 6

    @property
    def low(self) -> Vector:
        """Lower limits of the joints, (n,) [rad]."""
        return np.array(self.model.lowerPositionLimit[7:])

    @property
    def high(self) -> Vector:
        """Upper limits of the joints, (n,) [rad]."""
        return np.array(self.model.upperPositionLimit[7:])

    @cached_property
    def feet(self) -> tuple[int, int]:
        """Indices of the feet's joints."""
        left, right = (self.model.frames[frame].parentJoint for frame in self.sole_frames)
        return left, right

    @cached_property
    def legs(self) -> tuple[Leg, Leg]:
        """Left and right leg."""
        return find_legs(self.model, self.feet)

    @cached_property
    def pelvis(self) -> int:
        """Joint whose link carries the legs."""
        return find_pelvis(self.model, self.feet)

    @cached_property
    def trunk(self) -> int:
        """Joint whose link carries arms and head."""
        return find_trunk(self.model, self.feet)

    @cached_property
    def mass(self) -> float:
        """Mass of the whole robot [kg]."""
        return float(pinocchio.computeTotalMass(self.model))

    @cached_property
    def arms(self) -> tuple[int, ...]:
        """Joints of neither legs nor waist: arms, neck and what they carry."""
        others = {j for leg in self.legs for j in leg.joints} | {*self.waist}
        return tuple(j for j in range(2, self.model.njoints) if j not in others)

    @cached_property
    def waist(self) -> tuple[int, ...]:
        """Joints between pelvis and trunk."""
        chains = {*self.model.supports[self.trunk]} ^ {*self.model.supports[self.pelvis]}
        return tuple(sorted(chains - {1}))

    def trunk_axes(self, q: Vector) -> tuple[str, ...]:
        """Name the rotations of the trunk that the waist can make apart from the pelvis'.

        Args:
            q: Configuration, (nq,).
        """
        if self.trunk == self.pelvis:
            return ()
        model, data = self.model, self.model.createData()
        pinocchio.computeJointJacobians(model, data, q)
        pinocchio.forwardKinematics(model, data, q)
        world = pinocchio.LOCAL_WORLD_ALIGNED
        turns = [
            pinocchio.getJointJacobian(model, data, j, world)[3:, model.joints[j].idx_v]
            for j in self.waist
        ]
        basis, size, _ = np.linalg.svd(np.column_stack(turns), full_matrices=False)
        span = basis[:, size > 0.1]
        inside = np.linalg.norm(span, axis=1)
        return tuple(
            axis
            for axis, norm in zip(("rx", "ry", "rz"), inside, strict=True)
            if norm > TURNED_BY_JOINTS
        )

    def neutral(self) -> Vector:
        """Compute the configuration with joints at zero or their limit next to it, upright."""
        return upright_neutral(self.model, self.upright)


def upright_neutral(model: Any, upright: Matrix) -> Vector:
    """Compute the configuration with joints at zero or their limit next to it.

    Args:
        model: ``pinocchio.Model`` with a free-flyer.
        upright: Rotation of the base, (3, 3).
    """
    q: Vector = pinocchio.neutral(model)
    q[3:7] = pinocchio.Quaternion(upright).coeffs()
    q[7:] = np.clip(q[7:], model.lowerPositionLimit[7:], model.upperPositionLimit[7:])
    return q
