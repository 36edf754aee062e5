"""The inequalities of a QP where its equalities hold: x = x_0 + Z z."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.formulation.inverse_dynamics import QuadraticProgram
from tsd_casadi.state import Matrix, Vector

# of the largest singular value; the compiled elimination has the same
RANK_TOLERANCE = 1e-10
# [m/s^2, N] by which equalities that depend on each other may differ: they are sums of
# numbers up to 1e4 with 16 digits, and 1e-6 is what a tick's limits hold to
CONTRADICTION = 1e-6
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
        dependent: How many equalities follow from the others.
        contradicting: Indices of equalities that contradict each other, none usually;
            then the rest means nothing.
    """

    x_0: Vector
    Z: Matrix
    G: Matrix
    h: Vector
    rows: Indices
    sides: Indices
    is_bound: NDArray[np.bool_]
    dependent: int
    contradicting: Indices


def reduce_rows(program: QuadraticProgram, nv: int, n_equalities: int) -> ReducedRows:
    """Eliminate the equalities by a basis of their null space.

    Args:
        program: Rows in the order of ``InverseDynamics``: nv simple bounds, equalities,
            inequalities.
    """
    nx, end = program.A.shape[1], nv + n_equalities
    A, b = program.A[:n_equalities], program.lower[nv:end]
    U, values, Vt = np.linalg.svd(A)
    rank = int(np.sum(values > RANK_TOLERANCE * values[0]))
    x_0 = Vt[:rank].T @ ((U[:, :rank].T @ b) / values[:rank])
    Z = Vt[rank:].T
    rest = U[:, rank:] @ (U[:, rank:].T @ b)  # what no x reaches
    contradicting = np.flatnonzero(np.abs(rest) > CONTRADICTION)
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
        dependent=n_equalities - rank,
        contradicting=nv + contradicting,
    )
