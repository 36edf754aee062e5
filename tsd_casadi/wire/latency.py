"""How long answers took: counts by duration."""

from __future__ import annotations

from bisect import bisect_left
from typing import Annotated

from pydantic import Field, model_validator

from tsd_casadi.document import Document
from tsd_casadi.exceptions import MalformedMessage

# each bound twice the one before, from a fast tick to longer than any patience [us]
BOUNDS = tuple(25 * 2**power for power in range(18))

Count = Annotated[int, Field(ge=0)]


class LatencyMessage(Document):
    """A histogram of durations.

    Attributes:
        bounds: Upper ends of the bins, the last has none [us].
        counts: How many fell into each, one more than there are bounds.
    """

    bounds: tuple[int, ...] = BOUNDS
    counts: tuple[Count, ...]

    @model_validator(mode="after")
    def _check(self) -> LatencyMessage:
        if len(self.counts) != len(self.bounds) + 1:
            raise MalformedMessage(
                f"{len(self.counts)} counts of {len(self.bounds)} bounds", "one count more"
            )
        return self

    def quantile(self, share: float) -> float | None:
        """Find a duration that a share of all did not exceed, as the bound of its bin.

        Args:
            share: 0 to 1.

        Returns:
            Upper bound [us]; infinite beyond the last; None without any.
        """
        left = share * sum(self.counts)
        if not any(self.counts):
            return None
        for bound, count in zip((*self.bounds, float("inf")), self.counts, strict=True):
            left -= count
            if left <= 0:
                return float(bound)
        return float("inf")


class LatencyHistogram:
    """Counts durations."""

    def __init__(self) -> None:
        """Start with none."""
        self._counts = [0] * (len(BOUNDS) + 1)

    def add(self, seconds: float) -> None:
        """Count one duration [s]."""
        self._counts[bisect_left(BOUNDS, 1e6 * seconds)] += 1

    def message(self) -> LatencyMessage:
        """Write what was counted by now."""
        return LatencyMessage(counts=tuple(self._counts))
