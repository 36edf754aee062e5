r"""Integral action on the learned axis, what is tried first against a constant offset.

.. math:: \ddot x_{ff} \mathrel{+}= K_i \int (x_{ref} - x) \, dt

On a double integrator the error then obeys :math:`s^3 + D s^2 + P s + K_i`,
which is stable for :math:`K_i < P D` (Routh).
"""

from __future__ import annotations

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
        integral: What it adds now [m/s^2].
    """

    def __init__(self, Ki: float | None = None, limit: float = LIMIT) -> None:
        """Set the gain.

        Args:
            Ki: [1/s^3]; by default a ninth of P D of the task at the first tick.
            limit: The integral stops there, against winding up [m/s^2].

        Raises:
            InvalidValue: If a number is not positive.
        """
        for name, value in (("Ki", Ki), ("limit", limit)):
            if value is not None and not 0 < value < float("inf"):
                raise InvalidValue(name, value, "a positive number")
        self._given = Ki
        self._limit = limit
        self.integral = 0.0

    def start(self, setting: Setting) -> None:
        """Forget the last run."""
        self._setting = setting
        self._Ki = self._given
        self.integral = 0.0

    def before(self, moment: Moment) -> None:
        """Add what was summed up to the last tick."""
        moment.feedforward += self.integral

    def after(self, moment: Moment) -> None:
        """Sum up the error of this tick; a failed tick has none."""
        assert moment.tick is not None
        if moment.tick.status != Status.OK:
            return
        setting = self._setting
        if self._Ki is None:
            P, D = (moment.command[f"{setting.task}.{gain}"][setting.component] for gain in "PD")
            self._Ki = float(ROUTH_SHARE * P * D)
        wanted = self.integral + self._Ki * setting.dt * float(moment.tick.error[setting.axis])
        self.integral = min(max(wanted, -self._limit), self._limit)
