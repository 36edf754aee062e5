"""Named rows of the QP: lower <= A x <= upper with x = (qdd, lambda)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

# of a spatial vector, in the names of its rows
BASE_AXES = ("x", "y", "z", "rx", "ry", "rz")
# what DAQP takes for infinity
INFINITY = 1e30


@dataclass(frozen=True)
class Rows:
    """The rows of one constraint.

    Attributes:
        names: One name per row, for instance 'left_foot.friction.+x'.
        A: (rows, nv + l) with l forces in lambda: 6 for each sole, 3 for each point.
        lower: (rows,).
        upper: (rows,).
        equality: Whether lower equals upper in every row.
    """

    names: tuple[str, ...]
    A: ca.SX
    lower: ca.SX
    upper: ca.SX
    equality: bool = False


@dataclass(frozen=True)
class AccelerationBounds:
    """What something else than an acceleration limit makes of one.

    Attributes:
        lower: (n,) [rad/s^2].
        upper: (n,) [rad/s^2].
    """

    lower: ca.SX
    upper: ca.SX


def switched(active: ca.SX, bound: ca.SX, upper: bool) -> ca.SX:
    """Make bounds that count only where they are switched on.

    Args:
        active: 1, or 0 for infinite bounds.
        bound: (n,).
        upper: Which way infinity is.
    """
    nothing = INFINITY if upper else -INFINITY
    return active * bound + (1 - active) * nothing


def stack_rows(rows: Sequence[Rows]) -> Rows:
    """Put blocks of rows one below the other, in the order given.

    Returns:
        One block; it is an equality only if all are.
    """
    return Rows(
        names=tuple(name for block in rows for name in block.names),
        A=ca.vertcat(*[block.A for block in rows]),
        lower=ca.vertcat(*[block.lower for block in rows]),
        upper=ca.vertcat(*[block.upper for block in rows]),
        equality=all(block.equality for block in rows),
    )
