"""What entries at some points of the grid predict for the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from tsd_casadi.encoding.harmonics import sample_phases
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.generalization.weight_regression import WeightRegression
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.squat import Squat
from tsd_casadi.state import Matrix, Vector
from tsd_experiments.beyond.two_parameters.grid import NAMES, Point


class Predictions:
    """Feedforward predicted from entries, beside what was learned directly."""

    def __init__(self, entries: Mapping[Point, Matrix]) -> None:
        """Take what was learned.

        Args:
            entries: Weights by point, (1, L) [m/s^2].
        """
        self._entries = entries

    def regression(self, points: Sequence[Point]) -> WeightRegression:
        """Fit the regression to the entries at some points."""
        weights = [self._entries[point] for point in points]
        basis = PeriodicBasis.of_size(weights[0].shape[1])
        return WeightRegression(Squat.declaration(), NAMES, np.array(points), weights, basis)

    def interpolation(self, points: Sequence[Point]) -> Any:
        """Interpolate linearly between the entries at some points."""
        weights = [self._entries[point][0] for point in points]
        return LinearNDInterpolator(np.array(points), np.array(weights), rescale=True)

    def curves(self, regression: WeightRegression, point: Point) -> tuple[Vector, Vector, Vector]:
        """Compute mean, standard deviation and the learned curve over the phase."""
        mean, deviation = regression.predict(dict(zip(NAMES, point, strict=True)))
        weights = self._entries[point]
        basis = PeriodicBasis.of_size(weights.shape[1])
        predicted = Feedforward(("com.z",), basis, mean, deviation, "generalised")
        phase = sample_phases()
        return (
            predicted.mean(phase)[0],
            predicted.std(phase)[0],
            basis.evaluate(phase, weights)[0],
        )

    def off_by(self, points: Sequence[Point], held_out: Sequence[Point]) -> tuple[float, float]:
        """Compare the predicted curves with the learned ones.

        Returns:
            RMS difference of the regression and of linear interpolation over all
            points held out [m/s^2].
        """
        regression, linear = self.regression(points), self.interpolation(points)
        squares = []
        for point in held_out:
            mean, _, curve = self.curves(regression, point)
            weights = linear([point])
            basis = PeriodicBasis.of_size(weights.shape[1])
            straight = basis.evaluate(sample_phases(), weights)[0]
            squares.append([np.mean((each - curve) ** 2) for each in (mean, straight)])
        generalized, interpolated = np.sqrt(np.mean(squares, axis=0))
        return float(generalized), float(interpolated)

    def coverage(self, points: Sequence[Point]) -> list[float]:
        """Compute the share of each other curve within two predicted standard deviations."""
        regression = self.regression(points)
        return [
            float(np.mean(np.abs(curve - mean) <= 2 * std))
            for mean, std, curve in (
                self.curves(regression, point) for point in self._entries if point not in points
            )
        ]

    def coverage_of_draws(self, corners: Sequence[Point], count: int, draws: int) -> list[float]:
        """Compute the mean coverage for other choices of the learned entries.

        Returns:
            One share for each draw of so many out of all entries, the corners
            always among them; the others are held out.
        """
        rng = np.random.default_rng(0)
        others = [point for point in self._entries if point not in corners]
        shares = []
        for _ in range(draws):
            chosen = rng.choice(len(others), count - len(corners), replace=False)
            points = [*corners, *(others[i] for i in chosen)]
            shares.append(float(np.mean(self.coverage(points))))
        return shares
