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
    name: str, J: ca.SX, drift: ca.SX, standing: ca.SX, selection: ca.SX
) -> Rows:
    """Keep a foot from accelerating while it stands, by one equality per force.

    The rows are those of the foot or those of its force, never a mixture of the two: they
    have other units. What fades while a contact comes and goes is the force that it may carry.

    Args:
        J: Jacobian of the foot, the contact's axes, (6, nv) or (3, nv).
        drift: dJ/dt v, same axes, classical for translation, (6,) or (3,).
        standing: 1 while the contact carries anything, 0 where it does not.
        selection: (6, l) or (3, l), picks this contact's forces out of lambda.

    Returns:
        Rows J qdd + drift = 0 of a foot that stands, lambda = 0 of one that does not.
    """
    return Rows(
        names=tuple(f"{name}.acceleration.{axis}" for axis in BASE_AXES[: J.size1()]),
        A=ca.horzcat(standing * J, (1 - standing) * selection),
        lower=-standing * drift,
        upper=-standing * drift,
        equality=True,
    )
