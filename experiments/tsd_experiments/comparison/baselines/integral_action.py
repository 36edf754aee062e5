r"""Integral action on the learned axes, what is tried first against a constant offset.

.. math:: \ddot x_{ff} \mathrel{+}= K_i \int (x_{ref} - x) \, dt

On a double integrator the error then obeys :math:`s^3 + D s^2 + P s + K_i`,
which is stable for :math:`K_i < P D` (Routh).
"""

from __future__ import annotations

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.tick.format import Status

# of the Routh limit P D: three equal poles where D^2 = 3 P, a damping ratio of
# 0.74 where D = 2 sqrt(P)
ROUTH_SHARE = 1 / 9
LIMIT = 5.0  # m/s^2, half of gravity


class IntegralAction(Compensator):
    """Adds the integral of the error, from the first tick of the hold on.

    Attributes:
        integral: What it adds now, (k,) [m/s^2, rad/s^2].
    """

    def __init__(self, Ki: float | None = None, limit: float = LIMIT) -> None:
        """Set the gain.

        Args:
            Ki: [1/s^3]; by default a ninth of P D of each axis at the first tick.
            limit: The integral stops there, against winding up [m/s^2, rad/s^2].

        Raises:
            InvalidValue: If a number is not positive.
        """
        for name, value in (("Ki", Ki), ("limit", limit)):
            if value is not None and not 0 < value < float("inf"):
                raise InvalidValue(name, value, "a positive number")
        self._given = Ki
        self._limit = limit
        self.integral = np.zeros(0)

    def start(self, setting: Setting) -> None:
        """Forget the last run."""
        self._setting = setting
        k = setting.learned
        self._index = setting.index[:k]
        self._Ki = None if self._given is None else np.full(k, self._given)
        self.integral = np.zeros(k)

    def before(self, moment: Moment) -> None:
        """Add what was summed up to the last tick."""
        moment.feedforward[: len(self.integral)] += self.integral

    def after(self, moment: Moment) -> None:
        """Sum up the error of this tick; a failed tick has none."""
        assert moment.tick is not None
        if moment.tick.status != Status.OK:
            return
        setting = self._setting
        if self._Ki is None:
            P, D = (setting.gain(moment.command, gain)[: setting.learned] for gain in "PD")
            self._Ki = ROUTH_SHARE * P * D
        wanted = self.integral + self._Ki * setting.period * moment.tick.error[self._index]
        self.integral = np.clip(wanted, -self._limit, self._limit)
