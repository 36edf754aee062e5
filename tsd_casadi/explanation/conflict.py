r"""An irreducible set of rows that cannot hold together, and by how much.

The proof that rows G z <= h contradict each other are u >= 0 with G^T u = 0 and
h^T u < 0. Any z whatever then violates them by amounts v with u^T v >= -h^T u; that
is all that is needed, since the rows of an irreducible set depend on each other in
this one way. So a row that gives way alone has to by -h^T u / u_i.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tsd_casadi.explanation.least_distance import find_nearest_point
from tsd_casadi.explanation.reduced_rows import Indices, ReducedRows
from tsd_casadi.state import Vector

# Of accelerations [m/s^2, rad/s^2] and forces [N, N m] alike: in this unit both are of
# the order of 1, and the farthest point that counts as one is at 1e10.
UNIT = 1e3
# how much rather a limit of an acceleration is taken than another one
PREFERRED = 100.0


@dataclass(frozen=True)
class Conflict:
    """Rows that contradict each other; any one of them less, and the others do not.

    Attributes:
        places: Where they are in the reduced rows, (m,): limits of accelerations last,
            before that in the order of ``alone``.
        alone: By how much each would have to give way if it alone did, (m,), in the
            units of the rows.
    """

    places: Indices
    alone: Vector

    @property
    def violations(self) -> Vector:
        """By how much each gives way if all do, (m,), in the units of the rows.

        The elastic solution in which violations are weighed by what each row would
        need alone: all come to the same share of that, and no unit has to be
        compared with another.
        """
        return self.alone / len(self.alone)


def find_conflict(reduced: ReducedRows) -> Conflict | None:
    """Find an irreducible set of rows that contradict each other, None if there is none.

    Of several sets one with few rows besides the limits of accelerations: whoever
    asks wants to know which torque, which foot. A deletion filter (Chinneck and
    Dravnieks, ORSA Journal on Computing 3, 1991) over what the first proof needs.
    """
    h = reduced.h / UNIT
    preference = np.where(reduced.is_bound, PREFERRED, 1.0)
    kept = np.arange(len(h))

    def prove(among: Indices) -> Vector | None:
        point = find_nearest_point(reduced.G[among], h[among], preference[among])
        if point.z is not None:
            return None
        proof = np.zeros(len(h))
        proof[among] = point.multipliers
        return proof

    proof = prove(kept)
    if proof is None:
        return None
    norms = np.linalg.norm(reduced.G, axis=1)
    bounds = np.flatnonzero(reduced.is_bound)
    needed: set[int] = set()
    while True:
        others = np.flatnonzero((proof > 0) & ~reduced.is_bound)
        left = [int(place) for place in others if place not in needed]
        if not left:
            break
        # the one that matters least is the likeliest to be left out
        least = left[int(np.argmin((proof * norms)[left]))]
        shorter = prove(np.concatenate((bounds, others[others != least])))
        if shorter is None:
            needed.add(least)
        else:
            proof = shorter
    places = np.flatnonzero(proof > 0)
    alone = UNIT / proof[places]
    order = np.lexsort((alone, reduced.is_bound[places]))
    return Conflict(places[order], alone[order])
