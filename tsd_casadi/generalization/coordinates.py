"""From values of parameters to places of the process, in which their range is 2 wide."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.state import Matrix, Vector

# what is added to a value that counts by its ratio to the smallest, so that zero is a place too
NEAR_ZERO = 0.1


class Coordinates:
    """Maps the learned range of each parameter to -1 ... 1, straight or by ratios.

    By ratios a squat of 2 cm differs from one of 4 cm as that does from one of 8 cm.

    Attributes:
        low: Smallest learned value of each parameter, (d,).
        high: Largest learned value of each parameter, (d,).
        by_ratio: Whether any parameter counts by its ratios.
    """

    def __init__(self, inputs: Matrix, units: Vector) -> None:
        """Take the learned values.

        Args:
            inputs: (n, d).
            units: To which the ratios of each parameter are taken; NaN for those
                that count straight.
        """
        self.low: Vector = inputs.min(axis=0)
        self.high: Vector = inputs.max(axis=0)
        self._straight = np.isnan(units)
        self.by_ratio = not self._straight.all()
        self._units = np.where(self._straight, 1.0, units)

    @classmethod
    def possible(
        cls, declaration: Declaration, names: Sequence[str], inputs: Matrix
    ) -> list[Coordinates]:
        """List those that make sense: all straight, and what cannot be negative by ratios."""
        lows = {item.name: item.low for item in declaration.parameters}
        units = np.full(len(names), np.nan)
        for column, name in enumerate(names):
            values = inputs[:, column]
            if lows.get(name, -1.0) >= 0 and values.min() >= 0:
                units[column] = values[values > 0].min()
        straight = cls(inputs, np.full(len(names), np.nan))
        return [straight] if np.isnan(units).all() else [straight, cls(inputs, units)]

    def places(self, values: Matrix) -> Matrix:
        """Map values of the parameters, (m, d) to (m, d)."""
        low, high = self._bent(self.low), self._bent(self.high)
        return np.asarray(2 * (self._bent(values) - low) / (high - low) - 1)

    def _bent(self, values: Matrix) -> Matrix:
        ratio = np.where(self._straight, 1.0, values / self._units)
        return np.where(self._straight, values, np.log(NEAR_ZERO + ratio))
