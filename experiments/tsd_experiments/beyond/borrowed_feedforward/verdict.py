"""What became of a borrowed feedforward, and whether the gate was right."""

from __future__ import annotations

from dataclasses import dataclass

from tsd_experiments.harness.section import millimeters

# how far a case must be from a tie for the gate to be judged by it
TIE = 0.05


@dataclass(frozen=True)
class Verdict:
    """What became of one borrowed feedforward.

    Attributes:
        world: Where it was used.
        donor: Where it is from.
        none: RMS error without it [m].
        ungated: With it [m]; None if the robot fell.
        gated: With the gate [m]; None if the robot fell.
        dropped_after: Laps of motion until the gate dropped it; None if kept.
    """

    world: str
    donor: str
    none: float
    ungated: float | None
    gated: float | None
    dropped_after: float | None

    @property
    def harmful(self) -> bool:
        """Whether it is worse than none."""
        return self.ungated is None or self.ungated > self.none

    @property
    def tied(self) -> bool:
        """Whether it hardly matters."""
        return self.ungated is not None and abs(self.ungated / self.none - 1) < TIE

    @property
    def right(self) -> bool:
        """Whether the gate dropped what harms and kept what helps."""
        return self.harmful == (self.dropped_after is not None)

    def cells(self) -> list[str]:
        """Write the verdict as cells of a table."""
        dropped = self.dropped_after
        return [
            self.world,
            self.donor,
            millimeters(self.none),
            "fell" if self.ungated is None else millimeters(self.ungated),
            "fell" if self.gated is None else millimeters(self.gated),
            "kept" if dropped is None else f"{dropped:.2f}",
            ("right" if self.right else "wrong") + (" (tie)" if self.tied else ""),
        ]
