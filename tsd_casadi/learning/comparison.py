r"""Whether one iteration did worse than another, beyond what does not repeat.

Welch's test (Biometrika 34, 1947) of the number by which iterations are ranked,

.. math:: t = \frac{r - r'}{\sqrt{d^2 / M + d'^2 / M'}} ,

with the standard deviations d of a lap's rank, from those of its RMS errors, over M
laps each. Nobody who knows only one lap, or no deviation, can test: there every
larger error is a worse one.
"""

from __future__ import annotations

import math

from tsd_casadi.learning.iteration import Iteration

# probability that one that is as good is taken for worse. The best of some is so
# partly by luck: this for each of ten is one in a hundred for all of them
WORSE_LEVEL = 1e-3


def is_worse(tested: Iteration, best: Iteration) -> bool:
    """Say whether an iteration that was tested proved worse than another."""
    difference = tested.error - best.error
    if not difference > 0:
        return False
    variances = [_variance_of_error(tested), _variance_of_error(best)]
    known = [variance for variance in variances if variance is not None]
    if len(known) < 2 or sum(v for v, _ in known) == 0.0:
        return True
    from scipy.special import stdtr

    variance = sum(v for v, _ in known)
    # of Welch and Satterthwaite
    freedom = variance**2 / sum(v**2 / (laps - 1) for v, laps in known)
    return bool(stdtr(freedom, -difference / math.sqrt(variance)) < WORSE_LEVEL)


def _variance_of_error(iteration: Iteration) -> tuple[float, int] | None:
    """Compute the variance of ``error`` and its number of laps; None if unknown."""
    errors = list((iteration.errors or {}).values())
    laps = min((error.laps or 0 for error in errors), default=0)
    if laps < 2 or iteration.error == 0.0:
        return None
    P = (iteration.gains or {}).get("P") or [1.0] * len(errors)
    total = 0.0
    for stiffness, error in zip(P, errors, strict=True):
        if error.deviation is None:
            return None
        # by how much the rank moves with this axis' error
        slope = stiffness**2 * error.rms / (len(errors) * iteration.error)
        total += (slope * error.deviation) ** 2
    return total / laps, laps
