r"""Drops a borrowed feedforward that does more harm than good.

The error e of the learned axis and what the feedforward u contributes to it
obey, as far as the task is controlled by inverse dynamics,

.. math::

    \ddot e + D \dot e + P e = d - u, \qquad
    \ddot e_u + D \dot e_u + P e_u = u ,

with d what the model lacks. Their sum is the error that would be there without
feedforward, so that u makes tracking worse than none when

.. math:: \sum e^2 > \sum (e + e_u)^2 .

Squares are summed over the learned axes, each times its stiffness.
That is decided over a whole lap, and after half a lap already where the left
side is three times the right one. The feedforward is then faded out for the
rest of the repetition.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from tsd_casadi.repetition.compensator import Compensator, Moment, Setting
from tsd_casadi.state import Vector

FADE = 0.2  # s
# of squared errors: below it there is nothing to judge
NEGLIGIBLE = 1e-4**2  # m^2
# half a lap alone may mislead where offset and motion have both to be made up
# for; a feedforward of the wrong sign leaves twice the error, four times its square
CLEARLY_WORSE = 3.0


class FeedforwardGate(Compensator):
    """Watches one repetition's feedforward.

    Attributes:
        dropped_at: When it was dropped [s]; None while it is in use.
    """

    def __init__(self) -> None:
        """Start with the feedforward in use."""
        self.dropped_at: float | None = None

    @property
    def veto(self) -> str | None:  # type: ignore[override]
        """Why the feedforward is no longer in use."""
        if self.dropped_at is None:
            return None
        return (
            f"the feedforward was dropped at {self.dropped_at:.2f} s: tracking was worse with it "
            "than without"
        )

    def start(self, setting: Setting) -> None:
        """Note which axes are learned; a repetition starts with the feedforward in use."""
        self.dropped_at = None
        self._setting, self._index = setting, setting.index[: setting.learned]
        self._windows = (_Window(math.pi, CLEARLY_WORSE), _Window(2 * math.pi, 1.0))
        # e_u and its rate, and u as it left here: others may add to it
        self._moved, self._rate, self._u = np.zeros((3, setting.learned))

    def before(self, moment: Moment) -> None:
        """Fade the feedforward out once it is dropped."""
        if self.dropped_at is not None:
            left = 1 - (moment.time - self.dropped_at) / FADE
            moment.feedforward *= max(left, 0.0)
        self._u = moment.feedforward[: self._setting.learned].copy()

    def after(self, moment: Moment) -> None:
        """Judge what was seen so far; the hold before the motion is not judged."""
        if self.dropped_at is not None or moment.tick is None:
            return
        P, D = (self._setting.gain(moment.command, gain)[: len(self._u)] for gain in "PD")
        if moment.lap >= 0:
            error, scale = moment.tick.error[self._index], _square(P)
            if scale > 0:
                # axes count as the feedback counts them
                squares = (_square(P * each) / scale for each in (error, error + self._moved))
                # both windows have to see every tick
                with_it, without_it = squares
                worse = [w.add(moment.phase, with_it, without_it) for w in self._windows]
                if any(worse):
                    self.dropped_at = moment.time
        self._rate = self._rate + self._setting.period * (
            self._u - D * self._rate - P * self._moved
        )
        self._moved = self._moved + self._setting.period * self._rate


def _square(values: Vector) -> float:
    return float(values @ values)


class _Window:
    """Sums over the newest part of a repetition."""

    def __init__(self, length: float, ratio: float) -> None:
        """Start with nothing.

        Args:
            length: Of the part [rad of phase].
            ratio: How many times worse is too bad.
        """
        self._length = length
        self._ratio = ratio
        self._ticks: deque[tuple[float, float, float]] = deque()
        self._with = self._without = 0.0

    def add(self, phase: float, with_it: float, without_it: float) -> bool:
        """Take in a tick.

        Args:
            phase: phi [rad], not wrapped.
            with_it: e^2 [m^2].
            without_it: (e + e_u)^2 [m^2].

        Returns:
            Whether the window is full and u too bad in it.
        """
        self._ticks.append((phase, with_it, without_it))
        self._with += with_it
        self._without += without_it
        if phase - self._ticks[0][0] < self._length:
            return False
        allowed = self._ratio * self._without + NEGLIGIBLE * len(self._ticks)
        worse = self._with > allowed
        _, with_it, without_it = self._ticks.popleft()
        self._with -= with_it
        self._without -= without_it
        return worse
