r"""A foot on the ground does not accelerate [constraint2].

.. math:: J_c \ddot q + \dot J_c \dot q = 0

A contact that is switched off keeps its six rows, which then hold its wrench
at zero; so the size of the QP never changes.
"""

from __future__ import annotations

import casadi as ca

from tsd_casadi.constraints.rows import BASE_AXES, Rows


def contact_acceleration(
    name: str, J: ca.SX, drift: ca.SX, active: ca.SX, selection: ca.SX
) -> Rows:
    """Keep a sole from accelerating while it is in contact, by six equalities.

    Args:
        J: Jacobian of the sole, sole axes, (6, nv).
        drift: dJ/dt v, sole axes, classical for translation, (6,).
        active: 1 in contact, 0 not.
        selection: (6, 6 m), picks this contact's wrench out of lambda.

    Returns:
        Rows active (J qdd + drift) + (1 - active) lambda = 0.
    """
    return Rows(
        names=tuple(f"{name}.acceleration.{axis}" for axis in BASE_AXES),
        A=ca.horzcat(active * J, (1 - active) * selection),
        lower=-active * drift,
        upper=-active * drift,
        equality=True,
    )
