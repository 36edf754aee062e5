r"""What each active limit of a solved QP costs each task.

At the optimum, with multipliers mu of the active rows G_a z <= h_a,

.. math:: z^* = z_0 - K^{-1} G_a^T \mu, \qquad K = Z^T H Z,

z_0 being the optimum without limits. So the acceleration that tasks lose is a sum of
one term per active limit, and what else is missing was given up to other tasks and the
posture.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from tsd_casadi.explanation.least_distance import find_nearest_point
from tsd_casadi.explanation.reduced_rows import Indices, ReducedRows
from tsd_casadi.formulation.quadratic_program import QuadraticProgram
from tsd_casadi.state import Matrix, Vector


@dataclass(frozen=True)
class TaskCosts:
    """How much task acceleration is missing, k axes [m/s^2, rad/s^2].

    Attributes:
        x: The optimum (qdd, lambda), (nx,).
        active: Places of the active limits among the reduced rows, (m,).
        multipliers: Theirs, (m,): change of the cost per unit of the row.
        by_limit: Wanted minus reached because of each, (m, k).
        otherwise: What would be missing without any limit, (k,).
    """

    x: Vector
    active: Indices
    multipliers: Vector
    by_limit: Matrix
    otherwise: Vector


def find_task_costs(
    program: QuadraticProgram, reduced: ReducedRows, J: Matrix, wanted: Vector
) -> TaskCosts | None:
    """Solve the QP and share out what its tasks miss; None if it has no solution.

    Args:
        J: Stacked Jacobians of the tasks, (k, nv).
        wanted: What J qdd should be, (k,).

    Raises:
        numpy.linalg.LinAlgError: If the cost does not determine the solution.
    """
    nv, Z = J.shape[1], reduced.Z
    L = cholesky(Z.T @ program.H @ Z, lower=True)
    shift = solve_triangular(L, Z.T @ (program.H @ reduced.x_0 + program.g), lower=True)
    # w = L^T z + L^{-1} Z^T (H x_0 + g): the cost is |w|^2 / 2
    G = solve_triangular(L, reduced.G.T, lower=True).T
    h = reduced.h + G @ shift
    # in this unit the nearest point is of the order of 1, where it is most exact
    norms = np.linalg.norm(G, axis=1)
    unit = max(1.0, float(np.max(-h / np.where(norms > 0, norms, 1.0), initial=0.0)))
    nearest = find_nearest_point(G, h / unit)
    if nearest.z is None:
        return None
    active = np.flatnonzero(nearest.multipliers > 0)
    multipliers = unit * nearest.multipliers[active]
    along = J @ Z[:nv]

    def from_w(w: Vector) -> Vector:
        return np.asarray(solve_triangular(L, w, lower=True, trans="T"))

    free = reduced.x_0 + Z @ from_w(-shift)
    moved = from_w((-G[active] * multipliers[:, None]).T)
    return TaskCosts(
        x=free + Z @ moved.sum(axis=1),
        active=active,
        multipliers=multipliers,
        by_limit=-(along @ moved).T,
        otherwise=wanted - J @ free[:nv],
    )
