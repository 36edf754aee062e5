r"""The point nearest to the origin that satisfies inequalities, or the proof that none does.

Both come from one non-negative least squares problem, after Lawson and Hanson,
Solving Least Squares Problems (1974), chapter 23:

.. math:: \min_{u \ge 0} \| [G^T; h^T] u - [0; -1] \|

Its residual is zero if and only if G z <= h has no solution (Farkas' lemma: u proves
it); otherwise the nearest point is -G^T u / (1 + h^T u), and u over the same number
are its multipliers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from tsd_casadi.state import Matrix, Vector

# The residual is 1 / sqrt(1 + |z|^2) at the nearest point z, and rounding leaves some
# 1e-14 where there is none: points farther away than this count as none. The caller
# chooses units in which no robot gets near it.
FARTHEST = 1e7
# Rows whose coefficients are below this share of the largest one's are rounding:
# whether they hold is decided by their bounds alone.
NO_COEFFICIENTS = 1e-9
# Of the largest multiplier, rows scaled to length 1: where rows touch in more than one
# way rounding leaves multipliers of 1e-15, whose rows are not needed.
NEGLIGIBLE = 1e-12
# Lawson and Hanson take 3 steps a variable for a bound; cones that meet in a point
# took up to 9
STEPS = 30


@dataclass(frozen=True)
class NearestPoint:
    """The answer to G z <= h.

    Attributes:
        z: The point, (nz,); None if there is none.
        multipliers: (rows,), not negative. Of a point: z = -G^T multipliers. Of none:
            G^T multipliers = 0 and h^T multipliers = -1.
    """

    z: Vector | None
    multipliers: Vector


def find_nearest_point(G: Matrix, h: Vector, preference: Vector | None = None) -> NearestPoint:
    """Minimise the norm of z subject to G z <= h.

    The multipliers that prove that there is no point belong to linearly independent
    columns, which makes their rows irreducible: without any one of them the others
    can be satisfied (Gleeson and Ryan, Identifying Minimally Infeasible Subsystems of
    Inequalities, ORSA Journal on Computing 2, 1990).

    Args:
        G: (rows, nz).
        h: (rows,).
        preference: (rows,) above 0; where there are several proofs, rows with large
            numbers are taken rather than others. The nearest point is always the same.
    """
    if not len(h):
        return NearestPoint(np.zeros(G.shape[1]), np.zeros(0))
    norms = np.linalg.norm(G, axis=1)
    empty = norms <= NO_COEFFICIENTS * norms.max(initial=0.0)
    scale = (1.0 if preference is None else preference) / np.where(empty, 1.0, norms)
    columns = np.vstack((np.where(empty, 0.0, scale * G.T), scale * h))
    wanted = np.zeros(len(columns))
    wanted[-1] = -1.0
    u, residual = nnls(columns, wanted, maxiter=STEPS * len(h))
    if residual * FARTHEST < 1.0:
        u[u < NEGLIGIBLE * u.max()] = 0.0
        return NearestPoint(None, scale * u)
    rest = 1.0 + float(columns[-1] @ u)
    return NearestPoint(-(columns[:-1] @ u) / rest, scale * u / rest)
