"""What a learner answers for some parameters of a motion, as curves over the phase."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.learning.band import Band
from tsd_casadi.learning.circumstances import tell_differences
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.state import Vector
from tsd_casadi.wire.learner import EntryMessage

# a degree and a half each: the basis functions are 14 degrees apart
PHASE: Vector = np.linspace(0.0, 2 * np.pi, 241)
# kinds, their names and what they hold, for people
BANDS = (
    ("pointwise", "darker, pointwise", "the points of the curve that would be learned"),
    ("simultaneous", "lighter, simultaneous", "whole curves"),
)
# a feedforward this close to its bound was shrunk to it
AT_BOUND = 1e-3


@dataclass(frozen=True)
class LearnedCurve:
    """What was learned at an entry.

    Attributes:
        entry: The entry.
        feedforward: What is served of it.
    """

    entry: EntryMessage
    feedforward: Feedforward

    def over_phase(self, axis: str) -> Vector:
        """Compute its feedforward along an axis at ``PHASE``."""
        return _row(self.feedforward, self.feedforward.weights, axis)


@dataclass(frozen=True)
class Prediction:
    """An answer, or why there is none.

    Attributes:
        parameters: What was asked for, SI units.
        axes: Axes that were asked for.
        feedforward: The answer.
        refusal: Why there is none; empty if there is one.
        is_beyond: Whether it is refused since it would be an extrapolation.
        around: Entries nearby, the nearest first.
        exact: Number of the entry that is exactly there, if any.
    """

    parameters: dict[str, float]
    axes: tuple[str, ...]
    feedforward: Feedforward | None
    refusal: str
    is_beyond: bool
    around: tuple[LearnedCurve, ...]
    exact: int | None

    def over_phase(self, axis: str) -> Vector | None:
        """Compute the feedforward along an axis at ``PHASE``; None without an answer."""
        if self.feedforward is None:
            return None
        return _row(self.feedforward, self.feedforward.weights, axis)

    def band(self, kind: str, axis: str) -> tuple[Vector, Vector] | None:
        """Compute the lower and the upper end of a band at ``PHASE``; None without one.

        Args:
            kind: 'pointwise' or 'simultaneous'.
        """
        middle, band = self.over_phase(axis), self._find(kind)
        if self.feedforward is None or middle is None or band is None:
            return None
        half = _row(self.feedforward, band.half_width, axis)
        return middle - half, middle + half

    @property
    def origin(self) -> str:
        """Where the answer comes from, for people; empty if there is none."""
        if self.feedforward is None:
            return ""
        entries = self.feedforward.provenance["entries"]
        if self.feedforward.kind == "learned":
            return f"entry {entries[0]} is exactly there, iteration {self.feedforward.iteration}"
        return f"from entries {', '.join(map(str, entries))}"

    @property
    def disagreeing(self) -> list[str]:
        """Say which entries were left out and why, for people."""
        provenance = {} if self.feedforward is None else self.feedforward.provenance
        return [
            f"entry {each['entry']} disagrees: the others contradict it, it is "
            f"{each['deviations']:g} standard deviations off and left out"
            for each in provenance.get("disagreeing", [])
        ]

    def notes(self) -> list[str]:
        """Say what else is to be known of the answer, for people."""
        feedforward = self.feedforward
        if feedforward is None:
            return []
        said = [
            f"the {name} band is meant to hold {100 * band.coverage:.0f} % of {what}"
            for kind, name, what in BANDS
            for band in feedforward.bands
            if band.kind == kind
        ]
        said += self._about_bound(feedforward)
        if differences := tell_differences(feedforward.provenance.get("hardware", ())):
            said.append(f"its entries were learned on robots that differ ({differences})")
        if feedforward.provenance.get("others"):
            said.append(
                f"{feedforward.provenance['others']} entries of other contexts do not count"
            )
        if feedforward.provenance.get("note"):
            said.append(str(feedforward.provenance["note"]))
        return said

    def _about_bound(self, feedforward: Feedforward) -> list[str]:
        if feedforward.bound is None:
            return []
        said = []
        for axis, largest in zip(feedforward.axes, feedforward.bound.largest, strict=True):
            peak = float(np.abs(_row(feedforward, feedforward.weights, axis)).max())
            unit = unit_of_axis(axis)
            reached = ", shrunk to it" if peak > (1 - AT_BOUND) * largest > 0 else ""
            said.append(f"{axis} at most {largest:.3g} {unit}/s²{reached}")
        reason = f": {feedforward.bound.reason}" if feedforward.bound.reason else ""
        return [f"bounded{reason}; {'; '.join(said)}"]

    def _find(self, kind: str) -> Band | None:
        bands = () if self.feedforward is None else self.feedforward.bands
        return next((band for band in bands if band.kind == kind), None)


def _row(feedforward: Feedforward, weights: object, axis: str) -> Vector:
    index = feedforward.axes.index(axis)
    return np.asarray(feedforward.basis.evaluate(PHASE, weights)[index])  # type: ignore[arg-type]
