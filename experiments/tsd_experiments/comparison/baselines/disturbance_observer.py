r"""A disturbance observer on the acceleration of the learned axes.

The disturbance is what was commanded less what happened, behind a first-order
low pass Q of bandwidth g,

.. math::

    \hat d = Q(s) \, (\ddot x_{cmd} - s \dot x), \qquad Q(s) = \frac{g}{s + g},
    \qquad \ddot x_{cmd} = \ddot x_{ref} + \ddot x_{ff} + P e + D \dot e

and is added to the feedforward. Only a velocity is differenced, and only inside
Q: the sum is the usual :math:`Q (\ddot x_{cmd} + g \dot x) - g \dot x`. The
velocity comes from the tick, :math:`\dot x = \dot x_{ref} - (fb - P e) / D`.

On a double integrator this is nothing but a stiffer controller with integral
action, of gains :math:`P + g D`, :math:`D + g` and :math:`K_i = g P`: it pays
with the compliance that a feedforward leaves alone. Its loop crosses over near
D + g, so the lags between command and measurement, T in all, bound g.
"""

from __future__ import annotations

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.robot.robot import Robot
from tsd_casadi.state import Vector
from tsd_casadi.tick.format import Status

LIMIT = 5.0  # m/s^2, half of gravity


def usual_bandwidth(robot: Robot, D: float, crossover: float = 0.5) -> float:
    """Choose the bandwidth that puts the loop's crossover at a share of 1 / T.

    At P = 50, D = 2 sqrt(P) and T = 13 ms, half of it leaves a phase margin of
    47 degrees and a gain margin of 5.7, all of it 32 degrees and 2.8.

    Args:
        robot: The robot, whose file has the lags; without them g = D.
        D: Damping of the task [1/s].
        crossover: (D + g) T.

    Returns:
        g [rad/s].

    Raises:
        InvalidValue: If the lags leave no room for an observer.
    """
    hardware = robot.description.hardware
    lags = (
        (hardware.torque_lag, hardware.torque_delay, hardware.velocity_filter) if hardware else ()
    )
    if sum(lags) == 0.0:
        return D
    bandwidth = crossover / sum(lags) - D
    if bandwidth <= 0:
        raise InvalidValue(
            "D", f"{D:g} 1/s", f"below {crossover / sum(lags):g}, for an observer beside the lags"
        )
    return bandwidth


class DisturbanceObserver(Compensator):
    """Adds the observed disturbance, from the first tick of the hold on.

    Attributes:
        disturbance: The estimate, what it adds now, (k,) [m/s^2, rad/s^2].
    """

    def __init__(self, bandwidth: float | None = None, limit: float = LIMIT) -> None:
        """Set the bandwidth.

        Args:
            bandwidth: g [rad/s]; by default ``usual_bandwidth`` of the robot
                with D of each axis at the first tick.
            limit: The estimate stops there [m/s^2, rad/s^2].

        Raises:
            InvalidValue: If a number is not positive.
        """
        for name, value in (("bandwidth", bandwidth), ("limit", limit)):
            if value is not None and not 0 < value < float("inf"):
                raise InvalidValue(name, value, "a positive number")
        self._given = bandwidth
        self._limit = limit
        self.disturbance = np.zeros(0)

    def start(self, setting: Setting) -> None:
        """Forget the last run."""
        k = setting.learned
        self._setting, self._index = setting, setting.index[:k]
        # where each axis lies in its task's fields
        self._places = [
            (task, setting.controller.format.component_index(task, component))
            for task, _, component in (axis.rpartition(".") for axis in setting.axes[:k])
        ]
        self._last: tuple[Vector, Vector] | None = None
        self._bandwidth = None if self._given is None else np.full(k, self._given)
        self.disturbance = np.zeros(k)

    def before(self, moment: Moment) -> None:
        """Add the estimate of the last tick."""
        moment.feedforward[: len(self.disturbance)] += self.disturbance

    def after(self, moment: Moment) -> None:
        """Compare the last tick's command with the velocity gained since.

        Raises:
            InvalidValue: If D is zero, which hides the velocity.
        """
        assert moment.tick is not None
        if moment.tick.status != Status.OK:
            self._last = None
            return
        setting = self._setting
        fields = ("P", "D", "reference_velocity", "reference_acceleration", "feedforward")
        P, D, xd_ref, xdd_ref, xdd_ff = (
            np.array([moment.command[f"{task}.{field}"][place] for task, place in self._places])
            for field in fields
        )
        for axis, damping in zip(setting.axes, D, strict=False):
            if damping == 0.0:
                raise InvalidValue(f"D of {axis}", damping, "a damping above 0, to observe with")
        if self._bandwidth is None:
            self._bandwidth = np.array([usual_bandwidth(setting.robot, each) for each in D])
        feedback = moment.tick.feedback[self._index]
        velocity = xd_ref - (feedback - P * moment.tick.error[self._index]) / D
        if self._last is not None:
            commanded, velocity_then = self._last
            missing = commanded - (velocity - velocity_then) / setting.period
            share = 1 - np.exp(-self._bandwidth * setting.period)
            estimate = self.disturbance + share * (missing - self.disturbance)
            self.disturbance = np.clip(estimate, -self._limit, self._limit)
        self._last = (xdd_ref + xdd_ff + feedback, velocity)
