"""One set of learned weights and how it did."""

from __future__ import annotations

from dataclasses import dataclass

from tsd_casadi.learning.axis_error import AxisError, rank
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.state import Matrix


@dataclass(frozen=True)
class FittedRepetition:
    """What one repetition showed, over one basis.

    Attributes:
        weights: Feedforward in use, (k, L) [m/s^2].
        error: Position error, fitted, (k, L) [m].
        reference: Position reference, fitted, (k, L) [m].
    """

    weights: Matrix
    error: Matrix
    reference: Matrix


@dataclass
class Iteration:
    """Weights and, once a repetition used them, how well they did.

    Attributes:
        number: 0 for no feedforward, then counting up.
        weights: (k, L) [m/s^2].
        errors: Measures of the repetition that used them by axis, None while untested.
        circumstances: How that repetition was made.
        epoch: Counts how often the robot has changed before it.
        uncertainty: Standard deviation of each weight, as the scatter of the laps that
            it was learned from tells it, (k, L) [m/s^2]; None if unknown.
        feedback: What its feedback added, fitted, (k, L) [m/s^2].
        error_weights: Its position error, fitted, (k, L) [m]; None if unknown.
        reference_weights: Its reference, fitted, (k, L) [m]; None if unknown.
        learned_from: Number of the iteration whose repetition it was learned from, or
            of an earlier epoch's that it is again; None if it came from elsewhere or is
            not known.
    """

    number: int
    weights: Matrix
    errors: dict[str, AxisError] | None = None
    circumstances: Circumstances | None = None
    feedback: Matrix | None = None
    error_weights: Matrix | None = None
    reference_weights: Matrix | None = None
    learned_from: int | None = None
    epoch: int = 0
    uncertainty: Matrix | None = None

    @property
    def gains(self) -> dict[str, list[float]] | None:
        """P and D of the axes in the repetition that used them."""
        return None if self.circumstances is None else self.circumstances.gains

    @property
    def error(self) -> float:
        """By which iterations are ranked [m/s^2, rad/s^2], see ``rank``; infinite if untested."""
        if self.errors is None:
            return float("inf")
        P = (self.gains or {}).get("P") or [1.0] * len(self.errors)
        return rank(self.errors, P)

    @property
    def repetition(self) -> FittedRepetition | None:
        """What the repetition that used them showed; None if its positions are unknown."""
        if self.error_weights is None or self.reference_weights is None:
            return None
        return FittedRepetition(self.weights, self.error_weights, self.reference_weights)
