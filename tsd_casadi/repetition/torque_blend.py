"""From one torque to another without a step."""

from __future__ import annotations

import numpy as np

from tsd_casadi.state import Vector

# Of each joint's limit in one period. From standing to any torque within the limits
# takes at most 40 periods then, while what one period adds to a joint's speed stays
# small: 5 % of 150 N m on 0.05 kg m^2, the lightest, are 0.15 rad/s in 1 ms.
LARGEST_STEP = 0.05


class TorqueBlend:
    """Bounds how far torques change from one period to the next around missing answers.

    Between answers torques pass unchanged, whatever their steps. From the last
    answer before a gap until the answers' torque is reached again, none of them
    changes by more than ``LARGEST_STEP`` of its limit in one period.
    """

    def __init__(self, limit: Vector) -> None:
        """Begin without a torque: the first one passes.

        Args:
            limit: Of each joint, (n,) [N m].
        """
        self._most = LARGEST_STEP * limit
        self._last: Vector | None = None
        self._blending = False

    def follow(self, tau: Vector, *, answered: bool) -> Vector:
        """Go towards a torque, as far as may be.

        Args:
            tau: Wanted, (n,) [N m].
            answered: Whether it is a controller's answer.

        Returns:
            What is to be applied, (n,) [N m].
        """
        if answered and not self._blending:
            self._last = tau
            return tau
        if self._last is None:
            self._last = tau
        step = np.clip(tau - self._last, -self._most, self._most)
        reached = self._last + step
        # exact where it arrives, also in the last digit
        reached = np.where(np.abs(step) < self._most, tau, reached)
        self._blending = not answered or not np.array_equal(reached, tau)
        self._last = reached
        return reached
