r"""From task parameters to weights by Gaussian process regression [generalization].

.. math:: F_{D_b}: \kappa \mapsto w

One process over amplitude, shared by all weights, each weight standardised.
Hyperparameters are fitted once per database content; a query is a few matrix
products.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from tsd_casadi.exceptions import EntryNotFound, OutsideTrainedRange
from tsd_casadi.state import Matrix, Vector

MINIMUM_ENTRIES = 2


class WeightRegression:
    """Gaussian process over one task parameter for all weights at once.

    Attributes:
        parameter: Name of the task parameter.
        unit: Its unit.
        inputs: Learned values, (n,), sorted.
    """

    def __init__(
        self, parameter: str, unit: str, inputs: Sequence[float], weights: Sequence[Matrix]
    ) -> None:
        """Fit hyperparameters.

        Args:
            parameter: Name of the task parameter.
            unit: Its unit.
            inputs: Learned values, at least two different ones.
            weights: Learned weights, (k, L) each.

        Raises:
            EntryNotFound: If there are too few entries.
        """
        # imported here: it takes longer than everything else at start-up
        from sklearn.exceptions import ConvergenceWarning
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

        if len(inputs) < MINIMUM_ENTRIES:
            raise EntryNotFound(
                f"generalising over {parameter} needs at least {MINIMUM_ENTRIES} learned "
                f"entries beside the queried one, there are {len(inputs)}; learn more of them"
            )
        order = np.argsort(inputs)
        self.parameter = parameter
        self.unit = unit
        self.inputs: Vector = np.asarray(inputs, dtype=float)[order]
        self._shape = weights[0].shape
        targets = np.stack([weights[i].ravel() for i in order])
        self._low = self.inputs[0]
        self._span = self.inputs[-1] - self.inputs[0]
        # inputs on [0, 1]: a length scale of one spans the database
        kernel = ConstantKernel(1.0, (1e-2, 1e4)) * RBF(1.0, (0.2, 20.0)) + WhiteKernel(
            1e-4, (1e-8, 1e-1)
        )
        self._process = GaussianProcessRegressor(
            kernel=kernel, normalize_y=True, n_restarts_optimizer=2, random_state=0
        )
        with warnings.catch_warnings():
            # a bound that is met is a sensible answer for four entries
            warnings.simplefilter("ignore", ConvergenceWarning)
            self._process.fit(self._scale(self.inputs), targets)

    @property
    def kernel(self) -> str:
        """The fitted kernel, for people."""
        return str(self._process.kernel_)

    def predict(self, value: float, *, extrapolate: bool = False) -> tuple[Matrix, Matrix]:
        """Weights for a value of the parameter.

        Args:
            value: The value.
            extrapolate: Answer outside the learned range too.

        Returns:
            Mean and standard deviation, (k, L) each.

        Raises:
            OutsideTrainedRange: If the value is outside and that was not asked for.
        """
        low, high = float(self.inputs[0]), float(self.inputs[-1])
        if not extrapolate and not low <= value <= high:
            raise OutsideTrainedRange(self.parameter, value, low, high, self.unit)
        mean, std = self._process.predict(self._scale(np.array([value])), return_std=True)
        return mean.reshape(self._shape), std.reshape(self._shape)

    def _scale(self, values: Vector) -> Matrix:
        return np.asarray(((values - self._low) / self._span)[:, None])
