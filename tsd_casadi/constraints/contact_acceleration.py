r"""A foot on the ground does not accelerate [constraint2].

.. math:: J_c \ddot q + \dot J_c \dot q = 0

Six rows for a sole, the first three for a point. A contact that is switched off
keeps its rows, which then hold its forces at zero; so the size of the QP never
changes.
"""

from __future__ import annotations

import casadi as ca

from tsd_casadi.constraints.rows import BASE_AXES, Rows


def contact_acceleration(
    name: str, J: ca.SX, drift: ca.SX, active: ca.SX, selection: ca.SX
) -> Rows:
    """Keep a foot from accelerating while it is in contact, by one equality per force.

    Args:
        J: Jacobian of the foot, the contact's axes, (6, nv) or (3, nv).
        drift: dJ/dt v, same axes, classical for translation, (6,) or (3,).
        active: 1 in contact, 0 not.
        selection: (6, l) or (3, l), picks this contact's forces out of lambda.

    Returns:
        Rows active (J qdd + drift) + (1 - active) lambda = 0.
    """
    return Rows(
        names=tuple(f"{name}.acceleration.{axis}" for axis in BASE_AXES[: J.size1()]),
        A=ca.horzcat(active * J, (1 - active) * selection),
        lower=-active * drift,
        upper=-active * drift,
        equality=True,
    )
