"""One simulated setting as plain data: a robot's errors, a motion and gains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.feedforward import Feedforward, Kind
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.repetition.repeat import usual_axes
from tsd_casadi.robot.robot import Robot
from tsd_clients.simulator.model_error import ModelError
from tsd_clients.simulator.simulator import MujocoSimulator

TALL = 0.055  # m above home: knee at 1.0 rad
SOFT = 0.2  # of the robot's own P: 10 where that is 50


@dataclass(frozen=True)
class Case:
    """A robot, a motion and gains.

    Attributes:
        amplitude: [m].
        frequency: [Hz].
        height: Middle of the motion above home [m].
        model_error: E of every link.
        link_error: Further error with random sign on each link.
        link_seed: Of the signs.
        hardware: Hardware effects that count.
        p_scale: Factor on P.
        d_scale: Factor on D.
        laps: Least number of laps.
        seed: Of starting posture and sensor noise.
        learned: Which axes are learned: the one that is 'moved', as in the paper,
            or those that are 'usual', all of the centre of mass with it.
    """

    amplitude: float = 0.03
    frequency: float = 0.25
    height: float = 0.0
    model_error: float = 0.1
    link_error: float = 0.0
    link_seed: int = 0
    hardware: tuple[str, ...] = ()
    p_scale: float = 1.0
    d_scale: float = 1.0
    laps: int = 3
    seed: int = 0
    learned: Literal["moved", "usual"] = "moved"

    @property
    def motion(self) -> Squat:
        """The squat with these parameters."""
        return Squat(self.amplitude, self.frequency, self.height)

    @property
    def gains(self) -> Gains:
        """The factors on the gains."""
        return Gains(self.p_scale, self.d_scale)

    def at_stiffness(self, factor: float) -> Case:
        """Make the same case with P times a factor and the damping ratio kept."""
        gains = Gains.critical(factor)
        return replace(self, p_scale=gains.P, d_scale=gains.D)

    def axes(self, robot: Robot) -> tuple[str, ...]:
        """Name the learned axes, the one that is moved first."""
        if self.learned == "usual":
            return usual_axes(robot, self.motion)
        return self.motion.axes(robot)

    def simulator(self, robot: Robot) -> MujocoSimulator:
        """Make the simulated robot, with errors and hardware effects."""
        error = ModelError(self.model_error, self.link_error, self.link_seed)
        return MujocoSimulator(robot, error, self.hardware)

    def feedforward(self, robot: Robot, weights: Sequence[float], kind: Kind) -> Feedforward:
        """Make a feedforward for this case from bare weights.

        Args:
            weights: Along the axis that is moved, (L,) [m/s^2].
        """
        motion = self.motion
        matrix = np.asarray(weights, dtype=float)[None, :]
        return Feedforward(
            axes=motion.axes(robot),
            basis=PeriodicBasis.of_size(matrix.shape[1]),
            weights=matrix,
            standard_deviations=np.zeros_like(matrix),
            kind=kind,
            parameters=motion.parameters,
        )

    def plain(self) -> dict[str, Any]:
        """Write the case as plain data, which ``of`` reads."""
        return {**asdict(self), "hardware": list(self.hardware)}

    @classmethod
    def of(cls, plain: dict[str, Any]) -> Case:
        """Read a case from plain data."""
        return cls(**{**plain, "hardware": tuple(plain["hardware"])})
