r"""The ground pushes and does not pull, and carries no more than is stated.

.. math:: a f_{z,min} \le f_z \le a f_{z,max}

a is the contact's ``active``. While it fades the cone's other rows follow, because all
of them are multiples of f_z; where it is 0 the force is held at zero by other rows.
"""

from __future__ import annotations

import casadi as ca

from tsd_casadi.constraints.cone import FZ
from tsd_casadi.constraints.rows import Rows, switched


def unilateral_force(
    contact: str,
    minimum_force: ca.SX,
    maximum_force: ca.SX,
    active: ca.SX,
    nv: int,
    selection: ca.SX,
) -> Rows:
    """Keep a contact's normal force between its bounds, by one row.

    Args:
        minimum_force: Least normal force of a contact with active = 1 [N].
        maximum_force: Largest normal force of a contact with active = 1 [N].
        active: From 1 in contact to 0 not.
        selection: (6, l) or (3, l), picks this contact's forces out of lambda.

    Returns:
        Row active f_min <= f_z <= active f_max; no upper bound where active is 0.
    """
    return Rows(
        names=(f"{contact}.unilateral_force",),
        A=ca.horzcat(ca.SX(1, nv), selection[FZ, :]),
        lower=active * minimum_force,
        # a row of zeros with one value left is none that a solver expects
        upper=switched(active > 0, active * maximum_force, upper=True),
    )
