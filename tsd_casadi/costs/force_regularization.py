r"""Contact forces stay near what is wanted.

.. math:: \sum_i a_i \left\| \lambda_i / a_i - s \lambda_{i,des} \right\|^2_{W_{\lambda,i}},
    \qquad s = \frac{\sum_j f_{j,des}}{\sum_j a_j f_{j,des}}

a_i is the ``active`` of a contact, f_des the normal component of what it is wanted to
carry: a contact that fades carries a share of that, the weight of the share fades, and
those that stand take over the rest. With all a_i = 1 it is the paper's
:math:`\|\lambda - \lambda_{des}\|^2_{W_\lambda}`.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from tsd_casadi.constraints.cone import FZ

# The weight on lambda grows as 1 / a; below this it stays, so that a contact that has
# almost gone does not make the cost's numbers differ by more than they do anyway.
LEAST_FADING = 1e-3


def force_cost(W_lambda: ca.SX, lambda_des: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Write half the term in lambda as a Hessian and a gradient.

    Args:
        W_lambda: Diagonal of the weight, (l,) [1/N^2, 1/(N m)^2].
        lambda_des: (l,) [N, N m], each contact's axes.

    Returns:
        Diagonal of H (l,) and g (l,).
    """
    return W_lambda, -W_lambda * lambda_des


def fading_weight(W_lambda: ca.SX, active: ca.SX) -> ca.SX:
    """Write the weight on the forces of a contact that fades, W / a.

    Args:
        W_lambda: Diagonal of its weight with active = 1.
        active: From 1 in contact to 0 not.
    """
    return W_lambda / ca.fmax(active, LEAST_FADING)


def share_wanted_forces(active: Sequence[ca.SX], lambda_des: Sequence[ca.SX]) -> list[ca.SX]:
    """Write what contacts are wanted to carry while some of them fade, a_i s lambda_i,des.

    Args:
        active: Of each contact, from 1 in contact to 0 not.
        lambda_des: What each is wanted to carry with all of them at 1, (6,) or (3,).

    Returns:
        Of each contact, in the same order.
    """
    wanted = [forces[FZ] for forces in lambda_des]
    left = ca.dot(ca.vertcat(*active), ca.vertcat(*wanted))
    # where nobody is left, or nothing pushes, there is nothing to share
    s = ca.if_else(left > 0, ca.sum1(ca.vertcat(*wanted)) / left, 1)
    return [a * s * forces for a, forces in zip(active, lambda_des, strict=True)]
