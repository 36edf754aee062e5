r"""Contact forces stay near what is wanted.

.. math:: \|\lambda - \lambda_{des}\|^2_{W_\lambda}
"""

from __future__ import annotations

import casadi as ca


def force_cost(W_lambda: ca.SX, lambda_des: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Write half the term in lambda as a Hessian and a gradient.

    Args:
        W_lambda: Diagonal of the weight, (l,) [1/N^2, 1/(N m)^2].
        lambda_des: (l,) [N, N m], each contact's axes.

    Returns:
        Diagonal of H (l,) and g (l,).
    """
    return W_lambda, -W_lambda * lambda_des
