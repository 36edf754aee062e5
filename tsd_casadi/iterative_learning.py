r"""The learning update [x_fb_i-1].

.. math::

    \ddot x_{fb,i-1} = \ddot x_{fb,i-2} +
        P (x_{ref} - x_{i-1}) + D (\dot x_{ref} - \dot x_{i-1})

What the feedback had to add in one repetition is added to the feedforward of
the next. Both are linear in their weights over the same basis, so the sum is
taken there.
"""

from __future__ import annotations

from tsd_casadi.laps import Lap, join_laps
from tsd_casadi.periodic_basis import PeriodicBasis
from tsd_casadi.state import Matrix


def update_weights(
    applied: Matrix, laps: list[Lap], basis: PeriodicBasis, gain: float = 1.0
) -> Matrix:
    """Weights for the next repetition.

    Args:
        applied: Weights that the recorded repetition used, (k, L) [m/s^2].
        laps: Steady laps of that repetition, with its feedback term.
        basis: The basis of all weights.
        gain: 1 is the paper's rule; smaller is more careful.

    Returns:
        applied + gain * fitted, (k, L) [m/s^2].
    """
    phase, feedback = join_laps(laps)
    return applied + gain * basis.fit(phase, feedback)
