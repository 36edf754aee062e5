"""One set of learned weights and how it did."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

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
        errors: Measures of the repetition that used them, None while untested.
        gains: The gains of that repetition.
        feedback: What its feedback added, fitted, (k, L) [m/s^2].
        error_weights: Its position error, fitted, (k, L) [m]; None if unknown.
        reference_weights: Its reference, fitted, (k, L) [m]; None if unknown.
        learned_from: Number of the iteration whose repetition it was learned
            from, None if it came from elsewhere or is not known.
    """

    number: int
    weights: Matrix
    errors: dict[str, float] | None = None
    gains: dict[str, Any] | None = None
    feedback: Matrix | None = None
    error_weights: Matrix | None = None
    reference_weights: Matrix | None = None
    learned_from: int | None = None

    @property
    def error(self) -> float:
        """RMS error of the repetition that used them [m]; infinite if untested."""
        return self.errors["rms_error_m"] if self.errors else float("inf")

    @property
    def repetition(self) -> FittedRepetition | None:
        """What the repetition that used them showed; None if its positions are unknown."""
        if self.error_weights is None or self.reference_weights is None:
            return None
        return FittedRepetition(self.weights, self.error_weights, self.reference_weights)
