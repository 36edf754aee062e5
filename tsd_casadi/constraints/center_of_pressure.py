r"""The centre of pressure stays inside the sole.

With the wrench (f, m) in the sole frame, the centre of pressure is
:math:`p_x = -m_y / f_z`, :math:`p_y = m_x / f_z`; multiplied by f_z >= 0 its
bounds are linear.
"""

from __future__ import annotations

import casadi as ca

from tsd_casadi.constraints.cone import FZ, MX, MY, Faces, cone_rows
from tsd_casadi.constraints.rows import Rows


def center_of_pressure(contact: str, extents: ca.SX, nv: int, selection: ca.SX) -> Rows:
    """Keep a contact's centre of pressure inside its sole, by four rows.

    Args:
        extents: (x_low, x_high, y_low, y_high) of the sole [m], sole frame.
        selection: (6, l), picks this contact's wrench out of lambda.

    Returns:
        Rows x_low f_z <= -m_y <= x_high f_z and y_low f_z <= m_x <= y_high f_z.
    """
    faces: Faces = {
        "-x": {FZ: -extents[0], MY: -1.0},
        "+x": {FZ: extents[1], MY: 1.0},
        "-y": {FZ: -extents[2], MX: 1.0},
        "+y": {FZ: extents[3], MX: -1.0},
    }
    return cone_rows(f"{contact}.center_of_pressure", faces, nv, selection)
