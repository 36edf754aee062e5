r"""Gaussian process regression in closed form, for targets that share one kernel.

.. math::

    \mu(x) = k^T K^{-1} y, \qquad \sigma^2(x) = k(x, x) - k^T K^{-1} k

[Rasmussen and Williams, Gaussian Processes for Machine Learning, eqs. 2.23 to 2.26],
with K the kernel plus the noise of each entry on the diagonal.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.generalization.kernel import Kernel
from tsd_casadi.state import Matrix, Vector

# a prediction uses so many entries, the nearest: beyond them a curve hardly changes, and a
# query stays a matter of milliseconds however many there are
NEAREST = 120
# hyperparameters before anything is known: medians of log-normal distributions. Curvature and the
# rest, in units of a plane's slope: about half of what many entries of squats say, with which the
# deviations that three or four entries tell hold as often as they should; the noise (the most by
# which learning the same once more with other sensor noise differs); and a length scale of three
# quarters of the learned range, which is 2 wide
MEDIANS = (0.07, 0.07, 1e-4)
LENGTH = 1.5
# their standard deviations: a factor of 7 up and down, of the length scales 2. Few entries
# leave the medians, many override them
SPREAD = 2.0
LENGTH_SPREAD = 0.7
# noise below makes the covariance singular where entries lie close together; above, it is all noise
LEAST_NOISE, MOST_NOISE = 1e-6, 1.0
# logarithms are searched so many standard deviations around the medians: a trend is never trusted
# so far that a hole between entries is as certain as what is beside them
REACH = 2.0
# the likelihood has several maxima: it is climbed from the medians, and from a process
# that is all noise and plane
ELSEWHERE = (-2.0, -3.0, 4.0)
MOST_STEPS = 60
# places at once, so that memory stays bounded: along three axes 50 MB over a thousand entries
TOGETHER = 1000

Indices = NDArray[np.intp]


class GaussianProcess:
    """The posterior of some targets over places.

    Attributes:
        kernel: The kernel.
        cost: Minus the logarithm of how probable targets and hyperparameters were
            in the fit, but for a constant; zero if nothing was fitted.
    """

    def __init__(self, kernel: Kernel, places: Matrix, targets: Matrix, noise: Vector) -> None:
        """Take in what is known.

        Args:
            places: x, (n, d).
            targets: y, (n, m).
            noise: Variance of the noise of each place that is known to be there,
                beside that of the kernel, (n,).
        """
        self.kernel, self.cost = kernel, 0.0
        self._places, self._targets, self._noise = places, targets, noise
        self._inverse: Matrix | None = None
        if len(places) <= NEAREST:
            self._inverse = np.linalg.inv(self.known[0]).astype(float)

    @classmethod
    def fitted(cls, places: Matrix, targets: Matrix, noise: Vector) -> GaussianProcess:
        """Choose the most probable hyperparameters; the arguments are as above."""
        from scipy.optimize import minimize  # takes half a second

        count = places.shape[1]
        medians = np.log([*MEDIANS, *[LENGTH] * count])
        spreads = np.array([*[SPREAD] * len(MEDIANS), *[LENGTH_SPREAD] * count])
        low, high = medians - REACH * spreads, medians + REACH * spreads
        last = len(MEDIANS) - 1
        low[last], high[last] = np.log([LEAST_NOISE, MOST_NOISE])

        def cost(theta: Vector) -> tuple[float, Vector]:
            value, gradient = _unlikelihood(theta, places, targets, noise)
            off = (theta - medians) / spreads
            return value + float(off @ off) / 2, gradient + off / spreads

        starts = (medians, medians + np.array([*ELSEWHERE, *[0.0] * count]))
        found = [
            minimize(
                cost,
                start,
                jac=True,
                method="L-BFGS-B",
                bounds=list(zip(low, high, strict=True)),
                options={"maxiter": MOST_STEPS},
            )
            for start in starts
        ]
        best = min(found, key=lambda each: float(each.fun))
        process = cls(Kernel.of_logarithms(best.x), places, targets, noise)
        process.cost = float(best.fun)
        return process

    @property
    def known(self) -> tuple[Matrix, Matrix]:
        """K, noise included, (n, n), and the targets y, (n, m)."""
        return _with_noise(self.kernel, self._places, self._noise), self._targets

    def predict(self, place: Vector) -> tuple[Vector, float]:
        """Predict the targets at one place.

        Args:
            place: (d,).

        Returns:
            Their mean, (m,), and the standard deviation of each, with the noise.
        """
        near, inverse = self._near(place)
        covariance = self.kernel.covariance(place[None], self._places[near])[0]
        explained = inverse @ covariance
        mean = explained @ self._targets[near]
        return mean, float(self._deviation(place[None], covariance @ explained)[0])

    def deviations(self, places: Matrix) -> Vector:
        """Predict the standard deviation of a target at many places, from all entries.

        Args:
            places: (m, d).

        Returns:
            With the noise, (m,).
        """
        inverse = np.linalg.inv(self.known[0]) if self._inverse is None else self._inverse
        found = []
        for start in range(0, len(places), TOGETHER):
            part = places[start : start + TOGETHER]
            covariance = self.kernel.covariance(part, self._places)
            found.append(self._deviation(part, np.sum((covariance @ inverse) * covariance, axis=1)))
        return np.concatenate(found)

    def _deviation(self, places: Matrix, explained: Vector) -> Vector:
        # far outside the difference of two large numbers
        variance = np.maximum(self.kernel.variance(places) - explained, 0.0)
        return np.asarray(np.sqrt(variance + self.kernel.noise))

    def _near(self, place: Vector) -> tuple[Indices, Matrix]:
        """Choose the entries to predict from, and invert their covariance."""
        if self._inverse is not None:
            return np.arange(len(self._places)), self._inverse
        distances = np.linalg.norm((self._places - place) / self.kernel.lengths, axis=1)
        # in their order, so that the same ones give the same bits
        near = np.sort(np.argsort(distances, kind="stable")[:NEAREST])
        covariance = _with_noise(self.kernel, self._places[near], self._noise[near])
        return near, np.asarray(np.linalg.inv(covariance), dtype=float)


def _with_noise(kernel: Kernel, places: Matrix, noise: Vector) -> Matrix:
    return kernel.covariance(places, places) + np.diag(kernel.noise + noise)


def _unlikelihood(
    theta: Vector, places: Matrix, targets: Matrix, noise: Vector
) -> tuple[float, Vector]:
    """Compute minus the log likelihood of the targets, and its gradient [ibid., eq. 5.9]."""
    kernel = Kernel.of_logarithms(theta)
    covariance = _with_noise(kernel, places, noise)
    inverse = np.linalg.inv(covariance)
    explained = inverse @ targets
    count = targets.shape[1]
    value = (count * np.linalg.slogdet(covariance)[1] + np.sum(targets * explained)) / 2
    pairs = (count * inverse - explained @ explained.T) / 2
    return float(value), kernel.pull(places, pairs)
