"""Rows a^T w >= 0 on one contact's wrench w = (f, m), or force w = f, in its own axes."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from tsd_casadi.constraints.rows import INFINITY, Rows

# coefficients of each face by wrench component, by face name
Faces = Mapping[str, Mapping[int, ca.SX | float]]

FX, FY, FZ, MX, MY, MZ = range(6)


def cone_rows(prefix: str, faces: Faces, nv: int, selection: ca.SX) -> Rows:
    """Keep a contact's forces inside a polyhedral cone, by one row per face.

    Args:
        faces: Coefficients of each face by wrench component, by face name.
        selection: (6, l) or (3, l), picks this contact's forces out of lambda.

    Returns:
        One row a^T w >= 0 per face.
    """
    a = ca.SX.zeros(len(faces), selection.size1())
    for row, face in enumerate(faces.values()):
        for component, coefficient in face.items():
            a[row, component] = coefficient
    return Rows(
        names=tuple(f"{prefix}.{face}" for face in faces),
        A=ca.horzcat(ca.SX(len(faces), nv), a @ selection),
        lower=ca.SX.zeros(len(faces)),
        upper=INFINITY * ca.SX.ones(len(faces)),
    )
