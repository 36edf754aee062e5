r"""How much of what a repetition showed is learned, and how much may be noise.

The feedback f of M laps tells what is missing up to a variance s^2 of noise, and the
weights in use are off by a variance p of their own, from the laps that they were
learned from. Of the change that a rule proposes

.. math:: K = \frac{p}{p + s^2}, \qquad p = \max(p, \| f \|^2 - s^2)

is made, axis by axis, and K s^2 is left of p: Kalman's filter of something that
stands still, which averages all repetitions at the floor of the noise. There is more
to learn wherever the feedback is larger than noise explains; far above it K is 1.
"""

from __future__ import annotations

import numpy as np

from tsd_casadi.encoding.laps import FittedLaps
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.encoding.scatter import power_of
from tsd_casadi.state import Matrix, Vector


def trusted_share(fitted: FittedLaps, before: Matrix | None, basis: PeriodicBasis) -> Vector:
    """Compute K of each axis.

    Args:
        fitted: What the laps showed.
        before: Standard deviation of the weights in use, (k, L); None if unknown,
            which could be anything.

    Returns:
        (k,), above 0 up to 1.
    """
    feedback, scatter = fitted.feedback, fitted.scatter
    if scatter is None or before is None:
        return np.ones(len(feedback))
    noise = scatter.of_mean**2
    # relative to the noise from here on: p in weights, as it was noted, f in signals
    weights_noise = scatter.weights**2 / scatter.laps
    known = (noise > 0) & (weights_noise > 0)
    one = np.ones_like(noise)
    p = np.divide(np.mean(before**2, axis=1), weights_noise, out=one.copy(), where=known)
    f = np.divide(power_of(feedback, basis), noise, out=one.copy(), where=known)
    p = np.maximum(p, f - 1)
    return np.where(known, p / (p + 1), 1.0)
