r"""Contact rows that follow from others: legs with few joints, closed stances, straight knees.

The ground holds such a robot in more ways than it can move, so that some of the rows
J_c qdd = -dJ_c/dt v follow from those before them. How much a row says of its own is its
distance d from the span of the rows before it, as a share of its length. One with d below
``DEPENDENT`` is not held, from ``INDEPENDENT`` on it is, and in between it is held with

.. math:: t = \frac{d - d_0}{d_1 - d_0}, \qquad
    \frac{\kappa}{2} \frac{t^3}{1 - t} \left(n^T x - c\right)^2

in the cost, where the unit vector n is what it says beside all the others and c the value
that it asks for: nothing at d_0, all that an equality is at d_1, and no jump on the way.

This is the definition in numbers; ``native/elimination.c`` does the same while it
eliminates the equalities.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.formulation.quadratic_program import QuadraticProgram
from tsd_casadi.state import Matrix, Vector

# Shares of a row's length, which is 1 to 2 in m/s^2 per m/s^2 or rad/s^2. A row that is not
# held lets its foot accelerate by d times what the robot does in that direction: 1e-3 of it
# is less than a foot slips. Stances that are symmetric but for the feet's sinking in are below
# it, and robots with six joints in a leg were never below 0.03, with knees almost straight.
DEPENDENT = 1e-3
INDEPENDENT = 1e-2
# kappa, of an acceleration's square, as that of a task: half-way to an equality a row
# counts as much as what it hinders
HOLDING_WEIGHT = 1.0


@dataclass(frozen=True)
class PartlyHeld:
    """A row on its way from an equality to nothing.

    Attributes:
        row: Its place among the equalities.
        share: t, between 0 and 1.
        normal: n, (nx,), orthogonal to the rows that are held and to those before it here.
        value: c.
    """

    row: int
    share: float
    normal: Vector
    value: float


@dataclass(frozen=True)
class HeldRows:
    """Which equalities are held.

    Attributes:
        held: Places of those that are, in order.
        partly: Those in between.
        left_out: Places of those that follow from the others.
    """

    held: NDArray[np.intp]
    partly: tuple[PartlyHeld, ...]
    left_out: NDArray[np.intp]

    @property
    def dependent(self) -> int:
        """Number of those that are not held, or in part."""
        return len(self.partly) + len(self.left_out)


def sort_rows(A: Matrix, b: Vector) -> HeldRows:
    """Decide which of the equalities A x = b are held."""
    Q, x_0 = np.empty((0, A.shape[1])), np.zeros(A.shape[1])
    held, near, left_out = [], [], []
    partly = []

    def beside(row: int) -> tuple[float, Vector]:
        """Tell what a row says beside Q's: how much of its length, and which way."""
        rest = A[row] - Q.T @ (Q @ A[row])
        rest -= Q.T @ (Q @ rest)  # the first time leaves rounding of the whole row
        length = float(np.linalg.norm(rest))
        return length / float(np.linalg.norm(A[row])), rest / max(length, np.finfo(float).tiny)

    def value(row: int, normal: Vector) -> float:
        return float((b[row] - A[row] @ x_0) / (A[row] @ normal))

    for row in range(len(A)):
        distance, normal = beside(row)
        if distance < INDEPENDENT:
            near.append(row)
            continue
        held.append(row)
        x_0 = x_0 + value(row, normal) * normal
        Q = np.vstack((Q, normal))
    for row in near:
        distance, normal = beside(row)
        share = (distance - DEPENDENT) / (INDEPENDENT - DEPENDENT)
        if share <= 0:
            left_out.append(row)
            continue
        partly.append(PartlyHeld(row, share, normal, value(row, normal)))
        x_0 = x_0 + partly[-1].value * normal
        Q = np.vstack((Q, normal))
    return HeldRows(np.array(held, dtype=int), tuple(partly), np.array(left_out, dtype=int))


def add_partly_held(program: QuadraticProgram, rows: HeldRows) -> QuadraticProgram:
    """Put the rows that are held in part into the cost; all rows stay where they are."""
    H, g = program.H.copy(), program.g.copy()
    for part in rows.partly:
        weight = HOLDING_WEIGHT * part.share**3 / (1 - part.share)
        H += weight * np.outer(part.normal, part.normal)
        g -= weight * part.value * part.normal
    return replace(program, H=H, g=g)


def hold_independent_rows(program: QuadraticProgram, n_equalities: int) -> QuadraticProgram:
    """Leave the equalities that are held, and put those in between into the cost.

    Args:
        program: With rows that may depend on each other.
        n_equalities: How many of its rows, the first in A, are equalities.

    Returns:
        A program that any solver takes; its first rows in A are the held ones.
    """
    nv = len(program.lower) - len(program.A)
    rows = sort_rows(program.A[:n_equalities], program.lower[nv : nv + n_equalities])
    left = np.setdiff1d(np.arange(n_equalities), rows.held)
    return replace(
        add_partly_held(program, rows),
        A=np.delete(program.A, left, axis=0),
        lower=np.delete(program.lower, nv + left),
        upper=np.delete(program.upper, nv + left),
    )
