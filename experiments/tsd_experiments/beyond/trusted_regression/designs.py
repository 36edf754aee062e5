"""Choices of what is learned and what is held out."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.generalization.predictive_deviation import lap
from tsd_casadi.generalization.weight_regression import WeightRegression
from tsd_casadi.motions.squat import Squat
from tsd_casadi.state import Matrix
from tsd_experiments.beyond.trusted_regression.fixed_methods import Method
from tsd_experiments.beyond.trusted_regression.learned_terms import LearnedTerms

BASIS = PeriodicBasis()
CURVES = BASIS.values(lap(BASIS)).T
MICROMETER = 1e-6  # m


@dataclass(frozen=True)
class Design:
    """Entries to predict from, and what is held out.

    Attributes:
        names: Parameters, d of them.
        places: Of the entries, (n, d).
        weights: Of the entries, (n, L) [m/s^2].
        asked: Places held out, (m, d).
        wanted: What was learned there, (m, L) [m/s^2].
    """

    names: tuple[str, ...]
    places: Matrix
    weights: Matrix
    asked: Matrix
    wanted: Matrix

    @classmethod
    def draw(
        cls, terms: LearnedTerms, entries: int, seed: int, *, corners: bool, most: int
    ) -> Design:
        """Choose entries at random, all corners among them or not, and what is held out.

        Args:
            most: Places held out, at most.
        """
        rng = np.random.default_rng(seed)
        first = terms.corners if corners else np.array([], dtype=int)
        others = np.setdiff1d(np.arange(len(terms.places)), first)
        chosen = np.append(first, rng.choice(others, entries - len(first), replace=False))
        rest = np.setdiff1d(others, chosen)
        held_out = rng.choice(rest, min(most, len(rest)), replace=False)
        places, weights = terms.places, terms.weights
        return cls(
            terms.names, places[chosen], weights[chosen], places[held_out], weights[held_out]
        )

    def inside(self) -> Design:
        """Hold out what is within the learned range of every parameter, what is answered."""
        low, high = self.places.min(axis=0), self.places.max(axis=0)
        within = np.all((low <= self.asked) & (self.asked <= high), axis=1)
        return replace(self, asked=self.asked[within], wanted=self.wanted[within])

    def repeated(self, index: int, factor: float) -> Design:
        """Add an entry a micrometre beside another, with its weights times a factor."""
        beside = self.places[index].copy()
        beside[0] += MICROMETER
        return replace(
            self,
            places=np.vstack([self.places, beside]),
            weights=np.vstack([self.weights, factor * self.weights[index]]),
        )

    def regression(self) -> WeightRegression:
        """Fit the regression to the entries."""
        matrices = list(self.weights[:, None])
        return WeightRegression(Squat.declaration(), self.names, self.places, matrices, BASIS)

    def predicted(self, regression: WeightRegression) -> tuple[Matrix, Matrix]:
        """Predict what is held out: weights and those of the deviation, (m, L) each."""
        found = [
            regression.predict(dict(zip(self.names, place, strict=True)), extrapolate=True)
            for place in self.asked
        ]
        return np.array([mean[0] for mean, _ in found]), np.array([each[0] for _, each in found])

    def error(self, weights: Matrix) -> float:
        """Compute the RMS difference of the curves [m/s^2]."""
        return float(np.sqrt(np.mean(((weights - self.wanted) @ CURVES) ** 2)))

    def error_of(self, method: Method) -> float:
        """Compute the same for a method that is compared with."""
        return self.error(method(self.places, self.weights, self.asked))

    def wrong_signs(self, weights: Matrix) -> int:
        """Count the curves whose mean has another sign than that which was learned."""
        means = (weights @ CURVES).mean(axis=1) * (self.wanted @ CURVES).mean(axis=1)
        return int(np.sum(means <= 0))
