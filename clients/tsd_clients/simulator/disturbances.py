"""What a simulated robot is disturbed with, beyond its own model errors."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_clients.simulator.state_map import StateMap

# a run's time is a multiple of the time step, up to rounding
ROUNDING = 1e-9  # s


class Disturbance:
    """Does nothing; the base of what adds forces to a simulation."""

    def reset(self) -> None:
        """Start again; called once at the start of each run, before its first step."""

    def apply(self, data: Any, state_map: StateMap, time: float) -> None:
        """Add this step's forces to ``xfrc_applied`` and ``qfrc_applied``.

        Args:
            data: ``mujoco.MjData``; before the first disturbance both are zero.
            time: Of the run, at the start of the step [s].
        """


@dataclass(frozen=True)
class Push(Disturbance):
    """A constant force on the base for a short while.

    Attributes:
        start: [s].
        duration: A multiple of the time step, so that force times duration is
            the impulse [s].
        impulse: (3,) [N s], world axes.
    """

    start: float
    duration: float
    impulse: tuple[float, float, float]

    def __post_init__(self) -> None:
        """Refuse a push that takes no time, or that is no number.

        Raises:
            InvalidValue: If the duration is not positive, or something not finite.
        """
        if not 0 < self.duration < math.inf:
            raise InvalidValue("duration of a push", self.duration, "a time above 0 s")
        if not np.isfinite([self.start, *self.impulse]).all():
            raise InvalidValue("a push", f"{self.impulse} N s at {self.start} s", "finite numbers")

    def apply(self, data: Any, state_map: StateMap, time: float) -> None:
        """Push while it lasts, at the base body's centre of mass."""
        if -ROUNDING <= time - self.start < self.duration - ROUNDING:
            data.xfrc_applied[state_map.base_body, :3] += np.divide(self.impulse, self.duration)


@dataclass
class TorqueNoise(Disturbance):
    """White noise on every joint torque, the same in each run.

    Attributes:
        standard_deviation: Of each step [N m].
        seed: Of the noise.
    """

    standard_deviation: float
    seed: int = 0
    _rng: np.random.Generator = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Start the noise.

        Raises:
            InvalidValue: If the standard deviation is negative or no number.
        """
        if not 0 <= self.standard_deviation < math.inf:
            raise InvalidValue(
                "standard deviation of the torque noise", self.standard_deviation, "0 N m or more"
            )
        self.reset()

    def reset(self) -> None:
        """Start the noise again."""
        self._rng = np.random.default_rng((self.seed, 2))

    def apply(self, data: Any, state_map: StateMap, time: float) -> None:
        """Add this step's noise."""
        noise = self._rng.standard_normal(len(state_map.v_joints))
        data.qfrc_applied[state_map.v_joints] += self.standard_deviation * noise
