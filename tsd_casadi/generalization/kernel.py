r"""How alike the weights at two places are before anything is known of them.

.. math::

    k(x, x') = a (1 + p) + q\, (p / d)^2 (1 + p / 10) + r\, m(|x - x'|_\lambda), \qquad p = x^T x'

A plane as steep as the entries are, a is fixed; a polynomial of second and third degree
whose coefficients are normal [Rasmussen and Williams, Gaussian Processes for
Machine Learning, sections 2.7 and 4.2.2]; and a Matern 5/2 process m [ibid., eq. 4.17]
with a length scale lambda for each parameter. Of q and r only what the entries have
beyond a plane tells, which d + 1 of them have not at all. Rigid-body dynamics
are close to the polynomial over the range of a motion, which a few entries determine:
the acceleration of a squat, its amplitude times the square of its frequency, is of third
degree. Friction's steps move over the phase with the parameters, which is rougher than
the usual squared exponential. How much there is of each the entries say.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.state import Matrix, Vector

# what the third degree has of the variance of the second. Half of it predicts as well, three times
# as much worse; with a hyperparameter of its own a handful of entries was predicted worse
NEXT_DEGREE = 0.1
# variance of the plane's coefficients. Targets are in units of the slope of entries that a plane
# explains, the squares of its coefficients are three together: to fit this would tell that once
# more, and from two entries that nothing is left. With ten times as much three entries that nearly
# lie on a line are continued across it as if they told something there
PLANE = 2.0


@dataclass(frozen=True)
class Kernel:
    """The kernel with its hyperparameters, for targets in units of a plane's slope.

    Attributes:
        higher: q, of the second degree, and of the third in proportion.
        rough: r, variance of the Matern process.
        noise: Variance of what is different each time.
        lengths: lambda, (d,).
    """

    higher: float
    rough: float
    noise: float
    lengths: Vector

    @classmethod
    def of_logarithms(cls, theta: Vector) -> Kernel:
        """Make it from the logarithms of its hyperparameters, in their order."""
        higher, rough, noise, *lengths = np.exp(theta).tolist()
        return cls(higher, rough, noise, np.array(lengths))

    def __str__(self) -> str:
        """For people."""
        lengths = ", ".join(f"{length:.3g}" for length in self.lengths)
        return (
            f"plane + {self.higher:.3g} higher + {self.rough:.3g} Matern 5/2 "
            f"(length scales {lengths}) + noise {self.noise:.3g}"
        )

    def covariance(self, one: Matrix, other: Matrix) -> Matrix:
        """Compute k without the noise.

        Args:
            one: (m, d).
            other: (n, d).

        Returns:
            (m, n).
        """
        product = one @ other.T
        r = np.sqrt(5) * np.linalg.norm((one[:, None] - other) / self.lengths, axis=2)
        matern = (1 + r + r**2 / 3) * np.exp(-r)
        return np.asarray(self._trend(product) + self.rough * matern)

    def variance(self, places: Matrix) -> Vector:
        """Compute k(x, x) without the noise, (m,)."""
        return np.asarray(self._trend(np.sum(places**2, axis=1)) + self.rough)

    def pull(self, places: Matrix, weights: Matrix) -> Vector:
        """Compute how the sum of weights times k changes with each logarithm.

        Args:
            places: x, (n, d).
            weights: Of each pair of them, (n, n).

        Returns:
            Derivatives by the logarithms, in their order, (3 + d,).
        """
        product = places @ places.T
        # (d, n, n): squares of the differences in length scales
        squares = ((places.T[:, :, None] - places.T[:, None, :]) / self.lengths[:, None, None]) ** 2
        r = np.sqrt(5 * squares.sum(axis=0))
        decay = np.exp(-r)
        by_square = weights * (self.rough * 5 / 3 * (1 + r) * decay)
        return np.array(
            [
                self.higher * np.sum(weights * self._higher(product)),
                self.rough * np.sum(weights * (1 + r + r**2 / 3) * decay),
                self.noise * np.trace(weights),
                *(np.sum(by_square * square) for square in squares),
            ]
        )

    def _trend(self, product: NDArray[np.float64]) -> NDArray[np.float64]:
        return PLANE * (1 + product) + self.higher * self._higher(product)

    def _higher(self, product: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray((product / len(self.lengths)) ** 2 * (1 + NEXT_DEGREE * product))
