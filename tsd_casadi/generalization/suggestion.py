"""Which repetition would teach most: the next parameters to learn at."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tsd_casadi.exceptions import EntryNotFound, InvalidValue
from tsd_casadi.generalization.entry_regression import (
    EntryRegressions,
    is_learned,
    varied_parameters,
)
from tsd_casadi.learning.entry import Entry
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.state import Matrix, Vector

# (low, high) of each parameter that may be chosen, SI units
Region = Mapping[str, tuple[float, float]]

# candidates along one parameter, and about so many in all
FINEST_GRID = 41
MOST_CANDIDATES = 10_000
# to which the parameters of entries are rounded
DIGITS = 6
SAME = 1e-7


@dataclass(frozen=True)
class Suggestion:
    """Where to learn next.

    Attributes:
        parameters: All parameters of the motion, SI units.
        standard_deviation: How uncertain the feedforward is there, RMS over the
            lap and the axes [m/s^2, rad/s^2]; None while there are too few entries
            to tell.
        provenance: Which entries count, plain data.
        declaration: What is said of the motion; None if nobody did.
    """

    parameters: dict[str, float]
    standard_deviation: float | None
    provenance: dict[str, Any] = field(default_factory=dict)
    declaration: Declaration | None = None


def suggest(
    declaration: Declaration,
    entries: Sequence[Entry],
    regressions: EntryRegressions,
    region: Region,
    fixed: Mapping[str, float],
) -> Suggestion:
    """Find the most uncertain place of a region, on a grid that holds its corners.

    The hyperparameters of a handful of entries mean little. With fewer entries
    in the region than its middle and corners would be, the place is the one
    farthest from all of them, each length relative to the region; the middle
    comes first.

    Args:
        declaration: What is said of the motion.
        entries: Entries of it on one robot, of one context and one set of axes.
        regressions: Over such entries.
        region: (low, high) of each parameter that may be chosen, SI units.
        fixed: The other parameters, SI units.

    Returns:
        The place, with the predicted standard deviation there.

    Raises:
        InvalidValue: If a parameter is missing or makes no sense, or the region
            is empty.
        EntryNotFound: If the entries do not fit together, or every place in the
            region has one.
    """
    names, low, high = _ends(declaration, region, fixed)
    # repetitions that taught nothing count as well, not to be suggested for ever
    taken = _places(entries, names)
    taken = taken[np.all(_same(taken, low)[:, low == high], axis=1)]
    grid = _grid(low, high)
    is_taken = np.any(np.all(_same(grid[:, None], taken), axis=2), axis=1)
    grid = grid[~is_taken]
    if len(grid) == 0:
        raise EntryNotFound("every place of that region has an entry; name a larger region")
    deviations = _deviations(declaration, entries, regressions, names, grid)
    inside = np.sum(((low - SAME <= taken) & (taken <= high + SAME)).all(axis=1))
    if deviations is not None and inside > 2 ** len(region):
        best = int(np.argmax(deviations))
    else:
        best = _farthest(grid, taken, low, high)
    return Suggestion(
        parameters={
            name: round(v, DIGITS) for name, v in zip(names, grid[best].tolist(), strict=True)
        },
        standard_deviation=None if deviations is None else float(deviations[best]),
    )


def _ends(
    declaration: Declaration, region: Region, fixed: Mapping[str, float]
) -> tuple[tuple[str, ...], Vector, Vector]:
    """Tell names, lowest and highest values of all parameters."""
    if not region:
        raise InvalidValue("the region", "empty", "(low, high) of at least one parameter")
    for name, (lowest, highest) in region.items():
        if name in fixed or not lowest < highest:
            raise InvalidValue(
                f"the region of {name}",
                f"{lowest:g} to {highest:g}",
                f"the low value first, and no {name} beside it",
            )
    lows, highs = (
        declaration.complete({**fixed, **{name: ends[i] for name, ends in region.items()}})
        for i in (0, 1)
    )
    names = tuple(sorted(lows))
    # as entries are, so that a place is known again once it has one
    low = np.round([lows[name] for name in names], DIGITS)
    high = np.round([highs[name] for name in names], DIGITS)
    return names, low, high


def _places(entries: Sequence[Entry], names: tuple[str, ...]) -> Matrix:
    """Collect the parameters of the entries that have these and no others, (t, D)."""
    parameters = [dict(entry.key.parameters) for entry in entries]
    rows = [[each[name] for name in names] for each in parameters if each.keys() == set(names)]
    return np.array(rows).reshape(-1, len(names))


def _same(one: Matrix, other: Matrix) -> NDArray[np.bool_]:
    return np.abs(one - other) < SAME


def _grid(low: Vector, high: Vector) -> Matrix:
    """Lay out the candidates, (m, D)."""
    varied = int(np.count_nonzero(low < high))
    # an odd number, so that the middle is among them
    count = min(FINEST_GRID, int(MOST_CANDIDATES ** (1 / max(varied, 1))) // 2 * 2 + 1)
    lines = [np.linspace(a, b, count if a < b else 1) for a, b in zip(low, high, strict=True)]
    places = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, len(low))
    return np.round(places, DIGITS)


def _deviations(
    declaration: Declaration,
    entries: Sequence[Entry],
    regressions: EntryRegressions,
    names: tuple[str, ...],
    grid: Matrix,
) -> Vector | None:
    """Predict the standard deviation of each candidate, (m,); None if nobody can tell."""
    learned = [entry for entry in entries if is_learned(entry, names)]
    varied = varied_parameters(learned)
    if len(learned) <= max(len(varied), 1):
        return None
    same = [index for index, name in enumerate(names) if name not in varied]
    if not _same(grid, _places(learned[:1], names)[0])[:, same].all():
        return None  # the entries say nothing about another value of it
    regression = regressions.over(declaration, learned)
    return regression.deviation(grid[:, [names.index(name) for name in regression.names]])


def _farthest(grid: Matrix, taken: Matrix, low: Vector, high: Vector) -> int:
    """Find the candidate farthest from all places taken; the middle if there are none."""
    span = np.where(low < high, high - low, 1.0)
    if len(taken) == 0:
        return int(np.argmin(np.linalg.norm((grid - (low + high) / 2) / span, axis=1)))
    distances = np.linalg.norm((grid[:, None] - taken) / span, axis=2)
    return int(np.argmax(distances.min(axis=1)))
