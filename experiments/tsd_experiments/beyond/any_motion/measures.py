"""What the jobs of any motion have to show: ratios over iterations, seeds and axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_experiments.harness.job import Result


@dataclass(frozen=True)
class OverSeeds:
    """One number of the runs with several seeds.

    Attributes:
        values: One for each seed.
        larger_is_better: Which end of them is the worst.
    """

    values: Sequence[float]
    larger_is_better: bool = True

    @property
    def median(self) -> float:
        """The median."""
        return float(np.median(self.values))

    @property
    def worst(self) -> float:
        """The worst of them."""
        return min(self.values) if self.larger_is_better else max(self.values)

    def text(self) -> str:
        """Write both for a table; one number for one seed."""
        numbers = (self.median, self.worst)[: len(self.values)]
        return " / ".join(f"{x:.0f}" if x >= 1000 else f"{x:.3g}" for x in numbers)


def measure_of(row: dict[str, Any], axis: str, name: str = "rms_error") -> float:
    """Read a measure of one axis from a row.

    Args:
        axis: 'task.axis', a learned one.
        name: Of the measure, without unit.
    """
    place = row["axes"].index(axis)
    return float(row[f"{f'{axis}/' if place else ''}{name}_{unit_of_axis(axis)}"])


def times_smaller(
    results: Sequence[Result], axis: str, iteration: int, name: str = "rms_error"
) -> OverSeeds:
    """Compute how many times smaller an error is after some iterations than without.

    Args:
        results: One for each seed.
    """
    return OverSeeds(
        [
            measure_of(result.row("iteration 0"), axis, name)
            / measure_of(result.row(f"iteration {iteration}"), axis, name)
            for result in results
        ]
    )


def together_by_alone(together: Sequence[Result], alone: Sequence[Result], axis: str) -> OverSeeds:
    """Compute the RMS error after one iteration with all axes learned by that with one."""
    return OverSeeds(
        [
            measure_of(one.row("iteration 1"), axis) / measure_of(other.row("iteration 1"), axis)
            for one, other in zip(together, alone, strict=True)
        ],
        larger_is_better=False,
    )
