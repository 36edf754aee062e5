r"""The foot does not slide: a pyramid inside Coulomb's cone.

The normal is z of the contact's axes: the sole frame's, or the world's for a point.

.. math:: |f_x|, |f_y| \le \frac{\mu}{\sqrt 2} f_z
    \quad\Rightarrow\quad \sqrt{f_x^2 + f_y^2} \le \mu f_z
"""

from __future__ import annotations

import math

import casadi as ca

from tsd_casadi.constraints.cone import FX, FY, FZ, Faces, cone_rows
from tsd_casadi.constraints.rows import Rows


def friction(contact: str, mu: ca.SX, nv: int, selection: ca.SX) -> Rows:
    """Keep a contact's force inside the inscribed friction pyramid, by four rows.

    Args:
        mu: Coulomb coefficient.
        selection: (6, l) or (3, l), picks this contact's forces out of lambda.

    Returns:
        Rows of the inscribed pyramid.
    """
    side = mu / math.sqrt(2)
    faces: Faces = {
        "-x": {FZ: side, FX: 1.0},
        "+x": {FZ: side, FX: -1.0},
        "-y": {FZ: side, FY: 1.0},
        "+y": {FZ: side, FY: -1.0},
    }
    return cone_rows(f"{contact}.friction", faces, nv, selection)
