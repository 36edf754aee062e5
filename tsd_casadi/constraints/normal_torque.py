r"""The foot does not twist on the ground.

.. math:: |m_z| \le \gamma f_z
"""

from __future__ import annotations

import casadi as ca

from tsd_casadi.constraints.cone import FZ, MZ, Faces, cone_rows
from tsd_casadi.constraints.rows import Rows


def normal_torque(contact: str, gamma: ca.SX, nv: int, selection: ca.SX) -> Rows:
    """Bound a contact's moment about its normal, by two rows.

    Args:
        gamma: Torsional friction [m].
        selection: (6, l), picks this contact's wrench out of lambda.

    Returns:
        Rows of the resultant normal torque's bound.
    """
    faces: Faces = {"-z": {FZ: gamma, MZ: 1.0}, "+z": {FZ: gamma, MZ: -1.0}}
    return cone_rows(f"{contact}.normal_torque", faces, nv, selection)
