r"""From parameters of a motion to weights by Gaussian process regression [generalization].

.. math:: F_{D_b}: \kappa \mapsto w

One process over all parameters that differ, shared by all weights: a
Matern 5/2 kernel with a length scale for each parameter, and a little noise. It is
less smooth than the usual squared exponential, as friction's steps over the phase
move with the parameters. Magnitude and length scales are fitted once per database
content; a query is a few matrix products.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.exceptions import EntryNotFound, OutsideTrainedRange
from tsd_casadi.generalization.predictive_deviation import (
    deviation_scale,
    lap,
    leave_one_out,
    student_factor,
)
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.state import Matrix, Vector

# noise of learned weights, as a share of their variance: the most by which learning
# the same once more with other sensor noise differs. It is not fitted, since a
# dozen entries would have it make up for what the kernel cannot follow in a corner,
# and all predictions would be believed to be that bad
NOISE = 1e-4


class WeightRegression:
    """Gaussian process over some parameters of a motion for all weights at once.

    Attributes:
        declaration: What is said of the motion.
        names: Names of the parameters, d of them.
        low: Smallest learned value of each, (d,).
        high: Largest learned value of each, (d,).
    """

    def __init__(
        self,
        declaration: Declaration,
        names: Sequence[str],
        inputs: Matrix,
        weights: Sequence[Matrix],
        basis: PeriodicBasis,
    ) -> None:
        """Fit hyperparameters.

        Args:
            inputs: Learned values, (n, d), each parameter with two different
                ones at least.
            weights: Learned weights, n times (k, L).

        Raises:
            EntryNotFound: If there are too few entries.
        """
        # imported here: it takes longer than everything else at start-up
        from sklearn.exceptions import ConvergenceWarning
        from sklearn.gaussian_process import GaussianProcessRegressor

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
        self.low: Vector = inputs.min(axis=0)
        self.high: Vector = inputs.max(axis=0)
        self._inputs = self._scale(inputs)
        self._shape = weights[0].shape
        targets = np.stack([matrix.ravel() for matrix in weights])
        self._mean = targets.mean(axis=0)
        # one spread for all: what hardly varies has nothing to say of the kernel
        self._spread = float(np.sqrt(np.mean(targets.var(axis=0)))) or 1.0
        targets = (targets - self._mean) / self._spread
        process = GaussianProcessRegressor(
            _kernel(len(names)), alpha=0.0, n_restarts_optimizer=2, random_state=0
        )
        with warnings.catch_warnings():
            # a bound that is met is a sensible answer for a few entries
            warnings.simplefilter("ignore", ConvergenceWarning)
            process.fit(self._inputs, targets)
        self._kernel = process.kernel_
        covariance = process.L_ @ process.L_.T
        self._inverse = np.linalg.inv(covariance)
        self._coefficients = self._inverse @ targets
        residuals, deviations = leave_one_out(covariance, targets)
        self._residuals = (residuals * self._spread).reshape(-1, *self._shape)
        self._deviation_scale = deviation_scale(basis, self._residuals / deviations[:, None, None])

    @property
    def kernel(self) -> str:
        """The fitted kernel, for people."""
        return str(self._kernel)

    @property
    def length_scales(self) -> dict[str, float]:
        """Over what distance each parameter changes the weights, 1 for the learned range."""
        scales = np.atleast_1d(self._kernel.k1.k2.length_scale)
        return {name: float(scale) for name, scale in zip(self.names, scales, strict=True)}

    @property
    def calibration(self) -> dict[str, Any]:
        """How well the entries are predicted from one another, plain data."""
        residuals = self._residuals @ self.basis.values(lap(self.basis)).T
        return {
            "method": "leave-one-out",
            "residuals": np.sqrt(np.mean(residuals**2, axis=(1, 2))).tolist(),
            "unit": "m/s^2",
            "student_factor": student_factor(len(residuals)),
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
        covariance = self._kernel(self._scale(values[None, :]), self._inputs)
        mean = self._mean + self._spread * (covariance @ self._coefficients)[0]
        deviation = self._unit_deviation(values[None, :])[0]
        return mean.reshape(self._shape), deviation * self._deviation_scale

    def deviation(self, values: Matrix) -> Vector:
        """Predict how uncertain the feedforward is, also outside the learned range.

        Args:
            values: Values of the parameters, (m, d).

        Returns:
            Predictive standard deviation, RMS over the lap and the axes, (m,)
            [m/s^2].
        """
        scale = self.basis.evaluate(lap(self.basis), self._deviation_scale)
        return np.asarray(np.sqrt(np.mean(scale**2)) * self._unit_deviation(values))

    def _unit_deviation(self, values: Matrix) -> Vector:
        """Predict the standard deviation of a standardised weight, (m,)."""
        points = self._scale(values)
        covariance = self._kernel(points, self._inputs)
        explained = np.einsum("ij,jk,ik->i", covariance, self._inverse, covariance)
        return np.asarray(np.sqrt(self._kernel.diag(points) - explained))

    def _scale(self, values: Matrix) -> Matrix:
        """Map the learned range of each parameter to [0, 1]."""
        return np.asarray((values - self.low) / (self.high - self.low))


def _kernel(parameters: int) -> Any:
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    smooth = Matern(np.ones(parameters), (0.1, 100.0), nu=2.5)
    return ConstantKernel(1.0, (1e-2, 1e3)) * smooth + WhiteKernel(NOISE, "fixed")
