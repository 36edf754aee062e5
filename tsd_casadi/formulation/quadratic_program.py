"""The numbers of one QP."""

from __future__ import annotations

from dataclasses import dataclass

from tsd_casadi.state import Matrix, Vector


@dataclass(frozen=True)
class QuadraticProgram:
    """Minimise x^T H x / 2 + g^T x subject to lower <= (x_1..nv, A x) <= upper.

    Attributes:
        H: (nx, nx), positive definite.
        g: (nx,).
        A: (rows - nv, nx); the first nv rows are simple bounds and not in A.
        lower: (rows,).
        upper: (rows,).
    """

    H: Matrix
    g: Vector
    A: Matrix
    lower: Vector
    upper: Vector
