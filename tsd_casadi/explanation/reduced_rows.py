"""The inequalities of a QP where its equalities hold: x = x_0 + Z z."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.formulation.dependent_rows import HeldRows, sort_rows
from tsd_casadi.formulation.quadratic_program import QuadraticProgram
from tsd_casadi.state import Matrix, Vector

# bounds beyond this are none; ``constraints.rows.INFINITY`` is 1e30
UNBOUNDED = 1e29


Indices = NDArray[np.intp]


@dataclass(frozen=True)
class ReducedRows:
    """One-sided inequalities G z <= h.

    Attributes:
        x_0: The smallest x on which the equalities hold, (nx,).
        Z: Orthonormal basis of what they leave free, (nx, nz).
        G: (m, nz).
        h: (m,).
        rows: Index of each among the rows of the QP, (m,).
        sides: 1 for an upper bound, -1 for a lower one, (m,).
        is_bound: Whether it is a simple bound of one variable, (m,).
        held: Which of the equalities are held.
    """

    x_0: Vector
    Z: Matrix
    G: Matrix
    h: Vector
    rows: Indices
    sides: Indices
    is_bound: NDArray[np.bool_]
    held: HeldRows


def reduce_rows(program: QuadraticProgram, nv: int, n_equalities: int) -> ReducedRows:
    """Eliminate the equalities by a basis of their null space.

    Args:
        program: Rows in the order of ``InverseDynamics``: nv simple bounds, equalities,
            inequalities.
    """
    nx, end = program.A.shape[1], nv + n_equalities
    A, b = program.A[:n_equalities], program.lower[nv:end]
    held = sort_rows(A, b)
    rank = len(held.held)
    U, values, Vt = np.linalg.svd(A[held.held])
    x_0 = Vt[:rank].T @ ((U.T @ b[held.held]) / values)
    Z = Vt[rank:].T
    A_all = np.vstack((np.eye(nv, nx), program.A[n_equalities:]))
    index = np.concatenate((np.arange(nv), np.arange(end, len(program.lower))))
    lower, upper = program.lower[index], program.upper[index]
    there, along = A_all @ x_0, A_all @ Z
    above, below = np.flatnonzero(upper < UNBOUNDED), np.flatnonzero(lower > -UNBOUNDED)
    both = np.concatenate((above, below))
    return ReducedRows(
        x_0=x_0,
        Z=Z,
        G=np.vstack((along[above], -along[below])),
        h=np.concatenate(((upper - there)[above], (there - lower)[below])),
        rows=index[both],
        sides=np.repeat((1, -1), (len(above), len(below))),
        is_bound=both < nv,
        held=held,
    )
