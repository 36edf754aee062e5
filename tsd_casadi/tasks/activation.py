r"""How much a task counts while it comes or goes.

Each axis has a level :math:`s_i`, the task's ``active`` times its ``mask``, from 0 to 1.
It scales the weight,

.. math:: W_s = F W F, \qquad F = \mathrm{diag}(\sqrt{f_i}), \qquad
    f_i = \frac{s_i w}{(1 - s_i) W_{ii} + s_i w},

where w is the weight of what takes over, the posture's: along a free axis it is in series
with the task's, :math:`1 / (f_i W_{ii}) = 1 / W_{ii} + (1 - s_i) / (s_i w)`. With
s W the task, whose weight is a hundred or a thousand times the posture's, would stay as
it is until s is a hundredth, and the torque would go over all at once there. What the
level makes of the posture's projection is in ``costs.null_space_posture``.
"""

from __future__ import annotations

import casadi as ca

# beside weights, so that nothing is divided by zero; those that count are a million times it
LEAST_WEIGHT = 1e-12


def activation_levels(active: ca.SX, mask: ca.SX) -> ca.SX:
    """Compute the level of each axis.

    Args:
        active: 0 to 1.
        mask: (k,), 0 to 1.

    Returns:
        (k,), 0 to 1.
    """
    return active * mask


def weight_shares(level: ca.SX, weight: ca.SX, rest: ca.SX) -> ca.SX:
    """Compute f, what is left of a weight: exactly 0 at the level 0 and 1 at the level 1.

    Args:
        level: (k,), 0 to 1.
        weight: Of each axis, (k,).
        rest: Weight of what takes over, one for all or (k,).

    Returns:
        (k,), 0 to 1.
    """
    own, other = weight + LEAST_WEIGHT, rest + LEAST_WEIGHT
    return level * other / ((1 - level) * own + level * other)


def blended_weight(W: ca.SX, level: ca.SX, rest: ca.SX) -> ca.SX:
    """Scale a weight matrix by its axes' levels, W_s.

    Args:
        W: (k, k), symmetric.
        level: (k,), 0 to 1.
        rest: Weight of what takes over.

    Returns:
        (k, k), symmetric, positive semidefinite if W is.
    """
    root = ca.sqrt(weight_shares(level, ca.diag(W), rest))
    return root @ root.T * W
