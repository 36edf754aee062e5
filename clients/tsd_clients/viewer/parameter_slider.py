"""Where a slider for a motion's parameter goes from and to, and in which steps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from tsd_casadi.motions.parameter import Parameter

# of what the entries span, on each side: enough to see where extrapolation begins
BEYOND = 0.25
# of a value that all entries share, where nothing says how far others may be
AROUND = 0.5
# a slider is some 250 pixels wide: fewer steps are coarse, more cannot be told apart
STEPS, MOST_STEPS = 40, 500
# of what the values of entries have in common
PARTS = (1, 2, 5, 10, 20, 50, 100)
# parameters of entries are rounded to that, so finer steps say nothing
FINEST = 1e-6


@dataclass(frozen=True)
class ParameterSlider:
    """A slider, SI units.

    Attributes:
        name: Of the parameter.
        unit: Of the parameter; empty for a plain number.
        meaning: Of the parameter, a few words; empty if nobody said.
        low: Where it begins.
        high: Where it ends.
        step: Multiples of it are what can be chosen.
        learned_low: Smallest value of an entry; below it is extrapolated.
        learned_high: Largest value of an entry; above it is extrapolated.
        start: Where it stands at first: between two entries, so that there is something to predict.
    """

    name: str
    unit: str
    meaning: str
    low: float
    high: float
    step: float
    learned_low: float
    learned_high: float
    start: float

    @classmethod
    def over(cls, parameter: Parameter, learned: Sequence[float]) -> ParameterSlider:
        """Span the values of entries and some of what lies beyond.

        Args:
            parameter: What is said of it; its range is not left.
            learned: Values of the entries, at least one.
        """
        least, most = min(learned), max(learned)
        beyond = BEYOND * (most - least) or AROUND * abs(most) or FINEST
        step = _step(learned, most - least + 2 * beyond)
        low = step * math.floor((least - beyond) / step + FINEST)
        high = step * math.ceil((most + beyond) / step - FINEST)
        if least > 0 and low <= 0:
            low = step  # no motion at all is none that could be learned
        return cls(
            name=parameter.name,
            unit="" if parameter.unit == "1" else parameter.unit,
            meaning=parameter.meaning,
            low=round(min(max(low, parameter.low), least), 6),
            high=round(max(min(high, parameter.high), most), 6),
            step=step,
            learned_low=least,
            learned_high=most,
            start=_start(learned, step),
        )

    @property
    def is_movable(self) -> bool:
        """Whether there is anything to choose: not where all entries have none of it."""
        return self.high > self.low and (self.varies or self.learned_low != 0)

    @property
    def varies(self) -> bool:
        """Whether entries differ in it, so that it can be generalised over."""
        return self.learned_high > self.learned_low


def _step(learned: Sequence[float], span: float) -> float:
    """Find a step at which the values of all entries are met, or else a round one."""
    common = FINEST * math.gcd(*(round(value / FINEST) for value in learned))
    for parts in PARTS:
        step = common / parts
        if span / MOST_STEPS <= step <= span / STEPS:
            return round(step, 6)
    power = 10.0 ** math.floor(math.log10(max(span / STEPS, FINEST)))
    return max(round(power, 6), FINEST)


def _start(learned: Sequence[float], step: float) -> float:
    """Find the step in the middle of the widest gap between entries."""
    places = sorted(set(learned))
    if len(places) == 1:
        return places[0]
    low, high = max(pairwise(places), key=lambda gap: round((gap[1] - gap[0]) / step))
    middle = step * round((low + high) / 2 / step)
    return round(min(max(middle, low), high), 6)
