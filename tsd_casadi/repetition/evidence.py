r"""Whether a feedforward term helps, from what was seen over the newest part of a repetition.

With :math:`e_0` the error that would be there without a term and :math:`e_U` what
the whole of it moves, the error with it is :math:`e_0 - e_U`, so that

.. math:: |e_0|^2 - |e_0 - e_U|^2 = 2\, (\beta - \tfrac12)\, |e_U|^2, \qquad
          \beta = \frac{e_U \cdot e_0}{|e_U|^2} .

:math:`\beta` is the share of the term that is needed: 1 of what fits, 0 of what
has nothing to do with it, below 0 of a wrong sign, and a half of what neither
helps nor harms. Its mean over a lap, weighted by :math:`|e_U|^2`, compares the RMS
errors with and without. A push adds to :math:`e_0` without end, to the mean of a bounded
:math:`\beta` only for as long as it lasts.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

# on either side of a half. Of random terms with offset and two harmonics, this decides as the RMS
# error does wherever that differs by 18 % or more, and a term that fits (beta = 1) outweighs a
# push as long as that lasts less than a third of the part that is looked at
BOUND = 1.0
# of the mean of beta - 1/2 over half a lap, which alone may mislead where offset and motion have
# both to be made up for: a third of the squared error, where it is all offset
CLEAR = 0.134
# a term with less of an effect is not judged: no robot stands so still
NEGLIGIBLE = 1e-4  # m


class Seen(NamedTuple):
    """One tick.

    Attributes:
        surplus: (beta - 1/2) |e_U|^2, bounded.
        effect: |e_U|^2.
        with_it: |e_0 - e_U|^2.
        without_it: |e_0|^2.
    """

    surplus: float
    effect: float
    with_it: float
    without_it: float

    @classmethod
    def of(cls, effect: float, overlap: float, without_it: float) -> Seen:
        """Weigh one tick.

        Args:
            effect: |e_U|^2 [m^2], axes weighted as the feedback weighs them.
            overlap: e_U . e_0 [m^2], too.
            without_it: |e_0|^2 [m^2], too.
        """
        surplus = overlap - 0.5 * effect
        bounded = min(max(surplus, -BOUND * effect), BOUND * effect)
        return cls(bounded, effect, without_it - 2 * surplus, without_it)


class Evidence:
    """Sums over the newest ticks, at most so many."""

    def __init__(self, ticks: int) -> None:
        """Start with nothing.

        Args:
            ticks: How many count, the newest.
        """
        self._most = ticks
        self.forget()

    def forget(self) -> None:
        """Start anew."""
        self._seen: deque[Seen] = deque()
        self._surplus = self._effect = self._with = self._without = 0.0

    def add(self, seen: Seen) -> None:
        """Take in a tick, and forget the one that is too old."""
        self._seen.append(seen)
        self._surplus += seen.surplus
        self._effect += seen.effect
        self._with += seen.with_it
        self._without += seen.without_it
        if len(self._seen) > self._most:
            old = self._seen.popleft()
            self._surplus -= old.surplus
            self._effect -= old.effect
            self._with -= old.with_it
            self._without -= old.without_it

    @property
    def is_complete(self) -> bool:
        """Whether as many ticks were seen as count."""
        return len(self._seen) == self._most

    def harms(self, margin: float = 0.0) -> bool:
        """Say whether less than half of the term is needed.

        Args:
            margin: By how much beta has to differ from a half.
        """
        return -self._surplus > margin * self._effect + self._negligible

    def helps(self, margin: float = 0.0) -> bool:
        """Say whether more than half of the term is needed.

        Args:
            margin: By how much beta has to differ from a half.
        """
        return self._surplus > margin * self._effect + self._negligible

    @property
    def errors(self) -> tuple[float, float]:
        """RMS errors with the term and without it [m]."""
        count = max(len(self._seen), 1)
        # rounding may leave less than nothing of what was added and taken away
        with_it, without_it = max(self._with, 0.0), max(self._without, 0.0)
        return math.sqrt(with_it / count), math.sqrt(without_it / count)

    @property
    def _negligible(self) -> float:
        # half of the difference of the squares
        return 0.5 * NEGLIGIBLE**2 * len(self._seen)
