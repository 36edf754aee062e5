r"""How large a feedforward may be, whatever was recorded and by whatever rule it was learned.

Along each axis, over the lap,

.. math::

    \max_\phi |u(\phi)| \le \min\bigl(\tfrac32 \max_\phi |u_0(\phi) + u_{fb}(\phi)|,\ a_{max}\bigr)

with what was fed forward, u_0, and what feedback added, u_fb, in the repetitions that it
was learned from and tested in, and a_max what the torque limits allow at the motion, where
the recording tells it. The paper's sum is u_0 + u_fb itself; the other rules may ask for more
where the loop is slow.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.state import Matrix, Vector

# of what was recorded: half more than the feedback asked for is what a slow loop hides
MOST_OF_RECORDED = 1.5
# gravity, and what makes it at a radius of 0.1 m: a model that misses more is of nothing that
# stands on its feet
LARGEST_ACCELERATION = {"m": 9.81, "rad": 98.1}
# phases of a lap: 14 to each of the usual 25 functions
PHASES = np.linspace(0, 2 * np.pi, 360, endpoint=False)
RECORDED = f"{MOST_OF_RECORDED:g} times the largest feedback + feedforward recorded over a lap"
PLAUSIBLE = "what a robot's task may do at all: nobody knows what was recorded"
ALLOWED = "what the torque limits allow at the motion"


@dataclass(frozen=True)
class Bound:
    """The largest absolute value of a feedforward along each axis.

    Attributes:
        largest: (k,) [m/s^2, rad/s^2].
        reason: Where it comes from, for people.
    """

    largest: tuple[float, ...]
    reason: str

    @classmethod
    def of(
        cls,
        axes: Sequence[str],
        basis: PeriodicBasis,
        recorded: Iterable[Iteration],
        allowed: Sequence[float] = (),
    ) -> Bound:
        """Compute it from what repetitions recorded.

        Args:
            axes: Names 'task.axis', k of them.
            recorded: Those that were tested count.
            allowed: What the torque limits allow, (k,); empty if nobody said.
        """
        peaks = [
            peak(each.weights + each.feedback, basis)
            for each in recorded
            if each.feedback is not None
        ]
        bounds, reasons = [], []
        if peaks:
            bounds.append(MOST_OF_RECORDED * np.max(peaks, axis=0))
            reasons.append(RECORDED)
        if len(allowed):
            bounds.append(np.asarray(allowed))
            reasons.append(ALLOWED)
        if not bounds:
            bounds.append(np.array([LARGEST_ACCELERATION[unit_of_axis(axis)] for axis in axes]))
            reasons.append(PLAUSIBLE)
        return cls(tuple(np.min(bounds, axis=0).tolist()), ", and ".join(reasons))

    @classmethod
    def among(cls, axes: Sequence[str], bounds: Sequence[Mapping[str, float]]) -> Bound:
        """Bound what is generalised by the largest bound of the entries that it comes from.

        Args:
            axes: Names 'task.axis', k of them.
            bounds: Of each entry, by axis.
        """
        return cls(
            tuple(max(each[axis] for each in bounds) for axis in axes),
            f"the largest bound of the entries used, each {RECORDED}, and {ALLOWED} where known",
        )

    def over(self, rows: Sequence[int | None]) -> Bound:
        """Give the same for other axes: nothing may be along those that it does not know.

        Args:
            rows: Place of each axis among those of today, None if it is not among them.
        """
        return Bound(tuple(0.0 if row is None else self.largest[row] for row in rows), self.reason)

    def apply(self, weights: Matrix, basis: PeriodicBasis) -> Matrix:
        """Shrink what is too large, each axis as a whole: its shape stays.

        Args:
            weights: (k, L).
        """
        return weights * self.share(weights, basis)[:, None]

    def share(self, weights: Matrix, basis: PeriodicBasis) -> Vector:
        """Tell how much of each axis is left by the bound, (k,), 1 for all of it."""
        larger = np.maximum(peak(weights, basis), self.largest)
        return np.divide(self.largest, larger, out=np.ones_like(larger), where=larger > 0)


def peak(weights: Matrix, basis: PeriodicBasis) -> Vector:
    """Compute the largest absolute value over a lap along each axis, (k,)."""
    return np.asarray(np.abs(weights @ _values(basis).T).max(axis=1))


@lru_cache(maxsize=8)
def _values(basis: PeriodicBasis) -> Matrix:
    # nearly all have the same, and computing it takes longer than answering
    return basis.values(PHASES)
