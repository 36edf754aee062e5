r"""From parameters of a motion to weights by Gaussian process regression [generalization].

.. math:: F_{D_b}: \kappa \mapsto w

A process for each axis over all parameters that differ, shared by the weights of the
axis: a plane, a trend of third degree and what is left of both, see ``kernel``. Parameters that
cannot be negative count by their ratios unless that is clearly less probable. How much
there is of what, the entries say; with a handful of them it is little more than a
plane. Entries that the others contradict are left out and named.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.encoding.steadiness import ABSOLUTE_TOLERANCE
from tsd_casadi.exceptions import EntryNotFound, OutsideTrainedRange
from tsd_casadi.generalization.coordinates import Coordinates
from tsd_casadi.generalization.disagreement import (
    Processes,
    distance,
    limit,
    without_disagreeing,
)
from tsd_casadi.generalization.gaussian_process import NEAREST, GaussianProcess, Indices
from tsd_casadi.generalization.predictive_deviation import (
    COVERED,
    POINTS,
    WHOLE_LAPS,
    band_factor,
    deviation_scale,
    lap,
    leave_one_out,
    student_factor,
)
from tsd_casadi.learning.band import Band
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.state import Matrix, Vector

# hyperparameters are fitted to so many entries at most: a matter of seconds, and more entries
# hardly change them
FITTED = NEAREST
# no weight is known better than that [m/s^2, rad/s^2]: a tenth of what laps that agree differ by,
# all of which is a hundredth of how entries differ in a simulation without friction
KNOWN = ABSOLUTE_TOLERANCE / 10
# parameters that can count by their ratios do, unless straight the entries are more probable by a
# factor of e for each weight. The logarithm of what three to fifteen entries of the simulated
# hardware say is from -1.1 to 3 in favour of ratios; of four entries without friction -2.6 to -1.3
MUCH_MORE = 1.0


class WeightRegression:
    """Gaussian processes over some parameters of a motion for all weights at once.

    Attributes:
        declaration: What is said of the motion.
        names: Names of the parameters, d of them.
        low: Smallest learned value of each among the entries that count, (d,).
        high: Largest learned value of each among them, (d,).
        disagreeing: By how many standard deviations entries are off that the
            others contradict, by their index; they are left out.
    """

    def __init__(
        self,
        declaration: Declaration,
        names: Sequence[str],
        inputs: Matrix,
        weights: Sequence[Matrix],
        basis: PeriodicBasis,
        uncertainties: Sequence[Matrix | None] | None = None,
    ) -> None:
        """Fit hyperparameters.

        Args:
            inputs: Learned values, (n, d), each parameter with two different
                ones at least.
            weights: Learned weights, n times (k, L).
            uncertainties: Standard deviations of the weights of each entry, (k, L):
                its noise is at least that. Without, it is the same for all, as the
                entries say.

        Raises:
            EntryNotFound: If there are too few entries.
        """
        least = max(len(names) + 1, 2)
        if len(inputs) < least:
            raise EntryNotFound(
                f"generalising over {' and '.join(names) or declaration.motion} needs at least "
                f"{least} learned entries beside the queried one, there are {len(inputs)}; learn "
                "more"
            )
        self.declaration = declaration
        self.names = tuple(names)
        self.basis = basis
        targets = np.stack(weights, axis=1)  # (k, n, L)
        self._mean = targets.mean(axis=1)
        # of each axis one spread for all: what hardly varies has nothing to say of the kernel
        spread = np.sqrt(np.mean(targets.var(axis=1), axis=1)) / _width(inputs)
        self._spread = np.where(spread > 0, spread, 1.0)
        targets = (targets - self._mean[:, None]) / self._spread[:, None, None]
        self._fit(inputs, targets, self._noise(targets.shape[:2], uncertainties))
        # what was left out is no evidence of what is needed near it
        counting = np.delete(inputs, list(self.disagreeing), axis=0)
        self.low: Vector = counting.min(axis=0)
        self.high: Vector = counting.max(axis=0)

    def _fit(self, inputs: Matrix, targets: Matrix, noise: Matrix) -> None:
        sample = _sample(len(inputs))
        some = targets[:, sample], noise[:, sample]

        def fit(places: Matrix, kept: Indices) -> Processes:
            return [
                GaussianProcess.fitted(places[kept], each[kept], known[kept])
                for each, known in zip(*some, strict=True)
            ]

        found = []
        for coordinates in Coordinates.possible(self.declaration, self.names, inputs):
            processes = fit(coordinates.places(inputs[sample]), np.arange(len(sample)))
            cost = sum(each.cost for each in processes)
            if not coordinates.by_ratio:
                cost += MUCH_MORE * targets.shape[0] * targets.shape[2]
            found.append((cost, coordinates, processes))
        _, self._coordinates, processes = min(found, key=lambda each: each[0])
        places = self._coordinates.places(inputs)
        processes, off = without_disagreeing(
            partial(fit, places[sample]), processes, places[sample], *some
        )
        self.disagreeing = {int(sample[index]): distance for index, distance in off.items()}
        pairs = [leave_one_out(*process.known) for process in processes]
        relative = np.stack([r / d[:, None] for r, d in pairs], axis=1)
        self._residuals = np.stack([r for r, _ in pairs], axis=1) * self._spread[:, None]
        self._deviation_scale = deviation_scale(self.basis, relative, len(self.names))
        self._band_factor = band_factor(
            self.basis, relative, self._deviation_scale, len(self.names)
        )
        most = limit(len(sample), len(self.names))
        for index in np.setdiff1d(np.arange(len(places)), sample).tolist():
            if (off_by := distance(processes, places, targets, noise, index)) >= most:
                self.disagreeing[index] = off_by
        if len(sample) < len(places):
            kept = np.setdiff1d(np.arange(len(places)), list(self.disagreeing))
            processes = [
                GaussianProcess(process.kernel, places[kept], each[kept], known[kept])
                for process, each, known in zip(processes, targets, noise, strict=True)
            ]
        self._processes = processes

    @property
    def kernels(self) -> list[str]:
        """The fitted kernel of each axis, for people."""
        return [str(process.kernel) for process in self._processes]

    @property
    def length_scales(self) -> dict[str, float]:
        """Over what distance each parameter changes the weights, 1 for the learned range.

        That of the axis that varies most.
        """
        lengths = self._processes[int(np.argmax(self._spread))].kernel.lengths
        # places are 2 wide
        return {name: float(each) / 2 for name, each in zip(self.names, lengths, strict=True)}

    @property
    def calibration(self) -> dict[str, Any]:
        """How well the entries are predicted from one another, plain data."""
        residuals = self._residuals @ self.basis.values(lap(self.basis)).T
        return {
            "method": "leave-one-out",
            "residuals": np.sqrt(np.mean(residuals**2, axis=(1, 2))).tolist(),
            "unit": "m/s^2",
            "student_factor": student_factor(len(residuals), len(self.names)),
            "band_factors": self._band_factor.tolist(),
        }

    def predict(
        self, parameters: Mapping[str, float], *, extrapolate: bool = False
    ) -> tuple[Matrix, Matrix]:
        """Predict weights for some values of the parameters.

        Args:
            parameters: The values by name; others than the regression's are
                not looked at.
            extrapolate: Answer outside the learned range too.

        Returns:
            Mean, and weights of the predictive standard deviation of the
            feedforward over the phase, (k, L) each.

        Raises:
            OutsideTrainedRange: If a value is outside and that was not asked for.
        """
        values = np.array([parameters[name] for name in self.names])
        if not extrapolate:
            for name, value, low, high in zip(self.names, values, self.low, self.high, strict=True):
                if not low <= value <= high:
                    unit = self.declaration.unit_of(name)
                    raise OutsideTrainedRange(name, float(value), float(low), float(high), unit)
        place = self._coordinates.places(values[None])[0]
        means, deviations = zip(*(each.predict(place) for each in self._processes), strict=True)
        mean = self._mean + self._spread[:, None] * np.stack(means)
        return mean, (self._spread * deviations)[:, None] * self._deviation_scale

    def bands(self, deviation: Matrix) -> tuple[Band, ...]:
        """Make the bands around a prediction from its standard deviation.

        Args:
            deviation: As ``predict`` gives it, (k, L).
        """
        return (
            Band("pointwise", POINTS, COVERED * deviation),
            Band("simultaneous", WHOLE_LAPS, self._band_factor[:, None] * deviation),
        )

    def deviation(self, values: Matrix) -> Vector:
        """Predict how uncertain the feedforward is, also outside the learned range.

        Args:
            values: Values of the parameters, (m, d).

        Returns:
            Predictive standard deviation, RMS over the lap and the axes, (m,)
            [m/s^2].
        """
        scale = self.basis.evaluate(lap(self.basis), self._deviation_scale)
        by_axis = self._spread * np.sqrt(np.mean(scale**2, axis=1))
        places = self._coordinates.places(values)
        found = np.stack([process.deviations(places) for process in self._processes], axis=1)
        return np.asarray(np.sqrt(np.mean((by_axis * found) ** 2, axis=1)))

    def _noise(
        self, shape: tuple[int, ...], uncertainties: Sequence[Matrix | None] | None
    ) -> Matrix:
        """Compute the variance of the noise that is known to be there, (k, n)."""
        # where an axis hardly moves, rounding is neither a signal nor a contradiction
        noise = np.tile((KNOWN / self._spread[:, None]) ** 2, (1, shape[1]))
        for index, each in enumerate(uncertainties or ()):
            if each is not None:
                known = np.mean((each / self._spread[:, None]) ** 2, axis=1)
                noise[:, index] = np.maximum(noise[:, index], known)
        return noise


def _width(inputs: Matrix) -> float:
    """Compute how far apart entries lie, 1 for many that fill the learned range evenly.

    Weights of a plane at the two ends of a range differ more than at many places between.
    """
    low, high = inputs.min(axis=0), inputs.max(axis=0)
    return float(np.sqrt(12 * np.mean(((inputs - low) / (high - low)).var(axis=0))))


def _sample(count: int) -> Indices:
    """Choose the entries that hyperparameters are fitted to, evenly over all, their indices."""
    return np.unique(np.linspace(0, count - 1, min(count, FITTED)).astype(int))
