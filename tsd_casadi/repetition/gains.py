"""Softer or stiffer than the robot file says."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.tick.command import Command


@dataclass(frozen=True)
class Gains:
    """Factors on the learned task's gains.

    Attributes:
        P: On the stiffness.
        D: On the damping.
    """

    P: float = 1.0
    D: float = 1.0

    def __post_init__(self) -> None:
        """Refuse what is no factor.

        Raises:
            InvalidValue: If one is not above 0 and at most 100.
        """
        for name, value in (("p scale", self.P), ("d scale", self.D)):
            if not 0 < value <= 100:
                raise InvalidValue(name, value, "a factor above 0, up to 100")

    @classmethod
    def critical(cls, factor: float) -> Gains:
        """Scale P by a factor, with D = 2 sqrt(P) still true where it was.

        Args:
            factor: On the stiffness.

        Raises:
            InvalidValue: If it is not above 0 and at most 100.
        """
        return cls(factor, math.sqrt(max(factor, 0.0)))

    def scale(self, command: Command, task: str) -> None:
        """Scale the gains of a task in a command, couplings of its axes too."""
        for field, factor in (("P", self.P), ("D", self.D)):
            for name in (f"{task}.{field}", f"{task}.{field}_coupling"):
                if name in command.fields:  # one axis has no couplings
                    command[name] *= factor


UNCHANGED = Gains()
