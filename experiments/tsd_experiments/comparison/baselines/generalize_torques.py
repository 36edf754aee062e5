"""Joint torques for parameters that were never tried, as for task accelerations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.generalization.weight_regression import WeightRegression
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.state import Matrix
from tsd_experiments.comparison.baselines.torque_feedforward import TorqueFeedforward


def generalize_torques(
    declaration: Declaration, learned: Sequence[TorqueFeedforward], parameters: dict[str, float]
) -> TorqueFeedforward:
    """Generalise torques to parameters that were never tried, as task accelerations are.

    Args:
        declaration: Of the motion.
        learned: What was learned at other parameters; the regression is over
            those that differ.
        parameters: The parameters asked for, SI units.

    Returns:
        The predicted torques.

    Raises:
        InvalidValue: If nothing was learned.
        EntryNotFound: If too little was learned.
        OutsideTrainedRange: If a parameter is outside of what was learned.
    """
    if not learned:
        raise InvalidValue("learned", "empty", "torques learned at some other parameters")
    first = learned[0]
    names, inputs = varied([other.parameters for other in learned])
    regression = WeightRegression(
        declaration, names, inputs, [other.weights for other in learned], first.basis
    )
    mean, _ = regression.predict(parameters)
    return TorqueFeedforward(first.joints, first.basis, mean, dict(parameters))


def varied(parameters: Sequence[dict[str, float]]) -> tuple[list[str], Matrix]:
    """Tell which of some motions' parameters differ, and their values.

    Returns:
        Names of those that differ, d of them, and their values, (n, d).
    """
    names = [name for name in parameters[0] if len({each[name] for each in parameters}) > 1]
    return names, np.array([[each[name] for name in names] for each in parameters])
