"""What each test left of the feedback of the one that it was learned from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tsd_casadi.encoding.harmonics import highest_harmonic, to_harmonics
from tsd_casadi.encoding.periodic_basis import PeriodicBasis
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.feedback_loop import find_loop
from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.learning.iterative_learning import angular_frequencies
from tsd_casadi.state import Matrix, Vector

# harmonics of the feedback below this say nothing about contraction
SMALLEST_FEEDBACK = 2e-3  # m/s^2


def observe_contractions(
    key: EntryKey, basis: PeriodicBasis, iterations: Sequence[Iteration], axis: int
) -> Matrix | None:
    """Compute the shares of the feedback that were left, from test to test at the same gains.

    The feedback is C e of the position error where that is known, since the
    measured one lags.

    Returns:
        By pair of tests and harmonic, (pairs, N + 1); NaN where the feedback
        was too small to tell; None without a pair.
    """
    by_number: dict[int | None, Iteration] = {item.number: item for item in iterations}
    rows = []
    for item in iterations:
        before = by_number.get(item.learned_from)
        if before is None or item.errors is None:
            continue
        if item.gains != before.gains or item.epoch != before.epoch:
            continue
        left, all_of_it = _feedback_harmonics(key, basis, (item, before), axis)
        row = np.full_like(left, np.nan)
        rows.append(np.divide(left, all_of_it, out=row, where=all_of_it > SMALLEST_FEEDBACK))
    return np.array(rows) if rows else None


def last_observed(
    key: EntryKey, basis: PeriodicBasis, iterations: Sequence[Iteration], axis: int
) -> Vector:
    """Take of each harmonic the newest share that could be told, (N + 1,), or NaN."""
    observed = observe_contractions(key, basis, iterations, axis)
    last = np.full(highest_harmonic(basis) + 1, np.nan)
    for row in () if observed is None else observed:
        last = np.where(np.isnan(row), last, row)
    return last


def _feedback_harmonics(
    key: EntryKey, basis: PeriodicBasis, tests: tuple[Iteration, Iteration], axis: int
) -> list[Vector]:
    """Compute |C e| of two tests; that of the measured feedback if errors are unknown."""
    loop = find_loop(key.axes, dict(key.parameters), tests[0].gains)
    errors = [test.error_weights for test in tests if test.error_weights is not None]
    if loop is not None and len(errors) == len(tests):
        frequency, P, D = loop
        C = P[axis] + 1j * angular_frequencies(basis, frequency) * D[axis]
        return [np.abs(C * to_harmonics(basis, error)[axis]) for error in errors]
    return [
        np.abs(to_harmonics(basis, test.feedback)[axis])
        for test in tests
        if test.feedback is not None
    ]
