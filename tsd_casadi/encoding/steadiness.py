r"""From which lap on a repetition is steady.

Laps that agree with each other are. So are laps that scatter about something that
does not move, once there are enough of them for their mean to be as accurate as
two that agree. What moves is told by the second half of M laps against the first:
with the variance s^2 of a lap from the differences of consecutive ones (``scatter``),

.. math:: F = \frac{\| \bar f_{second} - \bar f_{first} \|^2}{s^2 (1/m_1 + 1/m_2)}

has Fisher's distribution where nothing moves.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.encoding.scatter import Scatter, power_of, scatter_of
from tsd_casadi.state import Matrix, Vector

# two consecutive laps agree when mean and AC RMS of the feedback do, to
RELATIVE_TOLERANCE = 0.01
ABSOLUTE_TOLERANCE = 1e-4  # m/s^2
# fewer scattering laps have no two halves that tell of each other
LEAST_SCATTERING = 4
# probability that laps which only scatter are taken for a drift
DRIFT_LEVEL = 1e-3
# numbers of a fitted lap that scatter by themselves: a third of the basis' 25, since
# the loop lets more noise through at low frequencies than at high ones
INDEPENDENT = 8
# of the variance from differences of consecutive laps, relative to M - 1 (von Neumann)
EFFICIENCY = 2 / 3


def _whole(lap: Lap) -> Matrix:
    """Add feedback and feedforward, (k, N)."""
    return lap.feedback if lap.feedforward is None else lap.feedback + lap.feedforward


def tolerance(size: Vector, units: Sequence[str]) -> Vector:
    """Compute how far apart laps that are steady may be along each axis.

    An axis along which next to nothing is added is as steady as those beside it: its
    size is that of the vector that all axes of its unit make.

    Args:
        size: Of feedback and feedforward together, (k,) [m/s^2, rad/s^2].
        units: Of each axis.

    Returns:
        (k,), in the axes' units by s^2.
    """
    together = np.array([[unit == other for other in units] for unit in units])
    return np.maximum(RELATIVE_TOLERANCE * np.sqrt(together @ size**2), ABSOLUTE_TOLERANCE)


def _agree(one: Lap, other: Lap, units: Sequence[str]) -> bool:
    whole = _whole(one)
    # the mean of a motion to and fro is next to nothing, and only noise
    for measure, size in (
        (np.mean, np.sqrt(np.mean(whole**2, axis=1))),
        (np.std, np.std(whole, axis=1)),
    ):
        a = measure(one.feedback, axis=1)
        b = measure(other.feedback, axis=1)
        if not bool(np.all(np.abs(a - b) < tolerance(size, units))):
            return False
    return True


def first_steady_lap(laps: Sequence[Lap], units: Sequence[str]) -> int | None:
    """Find the first lap from which on every lap agrees with the next.

    The very first one never counts: the motion begins smoothly in it.

    Args:
        laps: Whole laps in order.
        units: Of each axis.

    Returns:
        Its index, or None while the last two laps do not agree.
    """
    first = len(laps) - 1
    while first > 1 and _agree(laps[first - 1], laps[first], units):
        first -= 1
    return first if first < len(laps) - 1 else None


def steady_from(
    laps: Sequence[Lap], units: Sequence[str], is_last_chance: bool = False
) -> int | None:
    """Find the first lap from which on a repetition is steady, agreeing or scattering.

    Args:
        laps: Whole laps in order.
        units: Of each axis.
        is_last_chance: Take scattering laps though their mean is not accurate yet.

    Returns:
        Its index; None while it is not steady, or there are too few laps to tell.
    """
    basis = PeriodicBasis()
    fitted = [basis.fit(lap.phase, lap.feedback) for lap in laps]
    agreeing = first_steady_lap(laps, units)
    if agreeing is not None:
        # two laps may agree in these measures by luck
        scatter = scatter_of(fitted[agreeing:], basis)
        if is_last_chance or _is_accurate(laps[agreeing:], scatter, units):
            return agreeing
    # the very first one never counts: the motion begins smoothly in it
    for first in range(1, len(laps) - LEAST_SCATTERING + 1):
        scatter = scatter_of(fitted[first:], basis)
        if drifts(fitted[first:], scatter, basis):
            continue
        return first if is_last_chance or _is_accurate(laps[first:], scatter, units) else None
    return None


def drifts(fitted: Sequence[Matrix], scatter: Scatter, basis: PeriodicBasis) -> bool:
    """Say whether laps move along any axis by more than they scatter.

    Args:
        fitted: Weights of each lap, (k, L) each, at least ``LEAST_SCATTERING``.
    """
    from scipy.special import fdtrc

    half = len(fitted) // 2
    moved = power_of(np.mean(fitted[half:], axis=0) - np.mean(fitted[:half], axis=0), basis)
    noise = scatter.signal**2 * (1 / half + 1 / (len(fitted) - half))
    F = np.divide(moved, noise, out=np.zeros_like(moved), where=noise > 0)
    within = INDEPENDENT * EFFICIENCY * (len(fitted) - 1)
    # any of k axes
    return bool((fdtrc(INDEPENDENT, within, F) < DRIFT_LEVEL / len(F)).any())


def _is_accurate(laps: Sequence[Lap], scatter: Scatter, units: Sequence[str]) -> bool:
    """Say whether the mean of laps is known as well as that of two that just agree."""
    size = np.sqrt(np.mean([np.mean(_whole(lap) ** 2, axis=1) for lap in laps], axis=0))
    # laps a tolerance apart scatter by 1 / sqrt(2) of it, two of them by half on average
    return bool((scatter.of_mean <= tolerance(size, units) / 2).all())
