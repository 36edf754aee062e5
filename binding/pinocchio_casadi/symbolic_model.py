"""A numeric Pinocchio model as CasADi functions."""

from typing import Any

import casadi
import numpy as np
import pinocchio  # noqa: F401  (its wheel is the source of the headers compiled in)

from pinocchio_casadi import _core

SUPPORTED_JOINTS = (
    "JointModelFreeFlyer",
    "JointModelRX",
    "JointModelRY",
    "JointModelRZ",
    "JointModelRevoluteUnaligned",
    "JointModelPX",
    "JointModelPY",
    "JointModelPZ",
    "JointModelPrismaticUnaligned",
)


class UnsupportedJoint(ValueError):
    """A joint of the model has a type that the binding was not compiled for.

    Attributes:
        joint: Name of the joint.
        joint_type: Pinocchio's short name of its type.
    """

    def __init__(self, joint: str, joint_type: str) -> None:
        """Create the error for one joint."""
        self.joint = joint
        self.joint_type = joint_type
        super().__init__(
            f"joint '{joint}' is a {joint_type}, expected one of "
            f"{', '.join(SUPPORTED_JOINTS)}; lock the joint or give it limits "
            "(a URDF joint of type 'continuous' becomes 'revolute')"
        )


class SymbolicModel:
    """The dynamics and kinematics of one robot as CasADi functions.

    Every method runs Pinocchio's algorithm once on symbols and returns a new
    ``casadi.Function`` over SX.

    Attributes:
        model: The numeric ``pinocchio.Model`` that was taken.
        nq: Size of q.
        nv: Size of v.
    """

    def __init__(self, model: Any) -> None:
        """Copy a numeric model, joint by joint.

        Args:
            model: A ``pinocchio.Model``.

        Raises:
            UnsupportedJoint: If a joint's type is not in ``SUPPORTED_JOINTS``.
        """
        self.model = model
        self._symbolic = _core.SymbolicModel(np.array(model.gravity.linear))
        for index in range(1, model.njoints):
            self._add_joint(index)
        self.nq: int = self._symbolic.nq
        self.nv: int = self._symbolic.nv

    def _add_joint(self, index: int) -> None:
        joint = self.model.joints[index]
        joint_type = joint.shortname()
        if joint_type not in SUPPORTED_JOINTS:
            raise UnsupportedJoint(self.model.names[index], joint_type)
        unaligned = joint_type.endswith("Unaligned")
        axis = np.array(joint.extract().axis) if unaligned else np.zeros(3)
        placement = self.model.jointPlacements[index]
        inertia = self.model.inertias[index]
        self._symbolic.add_joint(
            parent=self.model.parents[index],
            type=joint_type,
            axis=axis,
            rotation=placement.rotation,
            translation=placement.translation,
            name=self.model.names[index],
            mass=inertia.mass,
            lever=inertia.lever,
            inertia=inertia.inertia,
            armature=self.model.armature[joint.idx_v : joint.idx_v + joint.nv],
        )

    def mass_matrix(self) -> casadi.Function:
        """Write the joint-space inertia, by the composite rigid body algorithm.

        Returns:
            Function q -> M, shape (nv, nv) [kg, kg m, kg m^2], symmetric,
            rotor inertias (armature) included.
        """
        return casadi.Function.deserialize(self._symbolic.mass_matrix())

    def bias_forces(self) -> casadi.Function:
        """Write Coriolis, centrifugal and gravity forces, by recursive Newton-Euler.

        Returns:
            Function (q, v) -> h, shape (nv,) [N, N m].
        """
        return casadi.Function.deserialize(self._symbolic.bias_forces())

    def center_of_mass(self) -> casadi.Function:
        """Write position, Jacobian and drift of the centre of mass, world frame.

        Returns:
            Function (q, v) -> c (3,) [m], J (3, nv), drift = dJ/dt v (3,)
            [m/s^2].
        """
        return casadi.Function.deserialize(self._symbolic.center_of_mass())

    def frame(self, name: str, *, local: bool) -> casadi.Function:
        """Write placement, Jacobian and drift of a frame.

        The drift is the frame's classical acceleration at zero joint
        acceleration, that is dJ/dt v for the velocity of its origin.

        Args:
            local: Jacobian and drift in the frame's own axes if true, in axes
                parallel to the world's otherwise.

        Returns:
            Function (q, v) -> p (3,) [m], R (3, 3), J (6, nv), drift (6,)
            [m/s^2, rad/s^2], rows [linear; angular].

        Raises:
            KeyError: If the model has no frame of that name.
        """
        if not self.model.existFrame(name):
            known = ", ".join(frame.name for frame in self.model.frames)
            raise KeyError(f"the model has no frame '{name}'; it has {known}")
        frame = self.model.frames[self.model.getFrameId(name)]
        return casadi.Function.deserialize(
            self._symbolic.frame(
                joint=frame.parentJoint,
                rotation=frame.placement.rotation,
                translation=frame.placement.translation,
                name=name,
                local=local,
            )
        )
