"""How much of a feedforward term is in use: in over a lap, out at once but not in a step."""

from __future__ import annotations

import math

import numpy as np

from tsd_casadi.state import Vector

# of a term that is dropped: 1 m/s^2, the term for a load of a tenth of the robot's own weight,
# then changes by less than 0.01 m/s^2 in a period
FADE = 0.2  # s
# slowest time constants of the loop after which its answer to a change is over: what is left of
# it then, at most (1 + x) exp(-x) of a critically damped one, is 2 % of what the end of a change
# still moves, and the ends are level
SETTLED = 6.0


class PhasedShare:
    """A share between 0 and 1 that changes smoothly: level where a change begins and ends."""

    def __init__(self, share: float) -> None:
        """Stay at a share until told otherwise."""
        self._from = self._to = share
        self._since, self._duration = 0.0, FADE

    def go_to(self, share: float, time: float, duration: float) -> None:
        """Change from where it is now.

        Args:
            share: Where to.
            time: Now [s].
            duration: Of the change [s].
        """
        self._from = self.at(time)
        self._to, self._since, self._duration = share, time, duration

    def at(self, time: float) -> float:
        """Tell the share at a time that is not before the newest change [s]."""
        x = min((time - self._since) / self._duration, 1.0)
        return self._from + (self._to - self._from) * x * x * (3 - 2 * x)


def settling_time(P: Vector, D: Vector) -> float:
    """Tell how long a loop moves after what drives it has stopped changing [s].

    Args:
        P: Stiffness of each axis, positive somewhere, (k,) [1/s^2].
        D: Damping of each axis, (k,) [1/s].

    Returns:
        ``SETTLED`` times the slowest time constant of s^2 + D s + P; infinite if
        nothing takes the movement away.
    """
    slowest = math.inf
    for stiffness, damping in zip(P, D, strict=True):
        if stiffness > 0:
            poles = np.roots([1.0, damping, stiffness])
            slowest = min(slowest, -float(poles.real.max()))
    return SETTLED / slowest if slowest > 0 else math.inf
