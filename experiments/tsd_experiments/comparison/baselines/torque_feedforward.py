"""Learned joint torques, and what adds them in the loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import SimulationError
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.state import Matrix


@dataclass(frozen=True)
class TorqueFeedforward:
    """Joint torques to add, as functions of the phase.

    Attributes:
        joints: Names of the n joints.
        basis: The basis of the weights.
        weights: (n, L) [N m].
        parameters: Of the motion that it is meant for, SI units.
    """

    joints: tuple[str, ...]
    basis: PeriodicBasis
    weights: Matrix
    parameters: dict[str, float] = field(default_factory=dict)

    @classmethod
    def zero(cls, joints: Sequence[str], parameters: dict[str, float]) -> TorqueFeedforward:
        """Make a feedforward of nothing learned yet."""
        basis = PeriodicBasis()
        return cls(tuple(joints), basis, np.zeros((len(joints), basis.L)), parameters)

    def mean(self, phase: ArrayLike) -> Matrix:
        """Compute the torques at some phases.

        Args:
            phase: (N,) [rad].

        Returns:
            (n, N) [N m].
        """
        return self.basis.evaluate(phase, self.weights)


class LearnedTorque(Compensator):
    """Adds a learned feedforward to the torques."""

    def __init__(self, feedforward: TorqueFeedforward) -> None:
        """Take what was learned."""
        self._feedforward = feedforward

    def start(self, setting: Setting) -> None:
        """Check the joints.

        Raises:
            SimulationError: If it was learned with other joints.
        """
        if self._feedforward.joints != tuple(setting.robot.joint_names):
            raise SimulationError(
                f"the torques are for {', '.join(self._feedforward.joints)}, {setting.robot.name} "
                f"has {', '.join(setting.robot.joint_names)}; learn them with this robot"
            )

    def after(self, moment: Moment) -> None:
        """Add the torques of this phase."""
        moment.tau = moment.tau + self._feedforward.mean([moment.phase])[:, 0]
