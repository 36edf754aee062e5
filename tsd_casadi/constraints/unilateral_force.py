r"""The ground pushes and does not pull.

.. math:: f_z \ge f_{z,min}
"""

from __future__ import annotations

import casadi as ca

from tsd_casadi.constraints.cone import FZ
from tsd_casadi.constraints.rows import INFINITY, Rows


def unilateral_force(
    contact: str, minimum_force: ca.SX, active: ca.SX, nv: int, selection: ca.SX
) -> Rows:
    """Keep a contact's normal force above its minimum, by one row.

    Args:
        minimum_force: Least normal force while in contact [N].
        active: 1 in contact, 0 not.
        selection: (6, l) or (3, l), picks this contact's forces out of lambda.

    Returns:
        Row f_z >= active f_min.
    """
    return Rows(
        names=(f"{contact}.unilateral_force",),
        A=ca.horzcat(ca.SX(1, nv), selection[FZ, :]),
        lower=active * minimum_force,
        upper=INFINITY * ca.SX.ones(1),
    )
