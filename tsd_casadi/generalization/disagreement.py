"""Entries that the others contradict, so that they do not pull the others' predictions."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tsd_casadi.generalization.gaussian_process import GaussianProcess, Indices
from tsd_casadi.generalization.predictive_deviation import leave_one_out, student_factor
from tsd_casadi.state import Matrix, Vector

# an entry disagrees if it is as improbable as a normal number that many standard deviations off; in
# deviations that few entries tell it is more, see ``student_factor``. It is the RMS over the
# weights of one axis
DISAGREES = 4.0
# beyond the others a prediction is an extrapolation, which contradicts nobody who is not off by
# more than that, in standard deviations of all entries
GROSS = 2.0
# an entry that is so little beyond the others is not, of a range that is 2 wide
MARGIN = 0.05
# of all entries, no more than this share can be in the wrong
MOST_WRONG = 0.25
# from fewer entries nobody tells which of two is in the wrong
LEAST_OTHERS = 4
# how many of the least expected ones are tried: two that contradict each other are equally
# unexpected as long as both count, and pull on a third
TRIED = 3

Processes = Sequence[GaussianProcess]


def without_disagreeing(
    fit: Callable[[Indices], Processes],
    processes: Processes,
    places: Matrix,
    targets: Matrix,
    noise: Matrix,
) -> tuple[Processes, dict[int, float]]:
    """Fit to all entries but those that the others contradict.

    Args:
        fit: Fits the processes, one per axis, to the entries of some indices.
        processes: What it gives for all.
        places: (n, d).
        targets: By axis, (k, n, L).
        noise: Variance that is known of the noise of each entry, (k, n).

    Returns:
        The processes, and by how many standard deviations each entry that was
        left out is off.
    """
    kept, off = np.arange(len(places)), dict[int, float]()
    while len(off) < int(MOST_WRONG * len(places)) and len(kept) > LEAST_OTHERS:
        suspects = kept[np.argsort(-_unexpected(processes))[:TRIED]]
        trials = []
        for suspect in suspects.tolist():
            others = kept[kept != suspect]
            fitted = fit(others)
            trials.append((sum(each.cost for each in fitted), suspect, others, fitted))
        # without the wrong one the others go together best
        _, suspect, others, fitted = min(trials, key=lambda trial: trial[0])
        off_by = distance(fitted, places, targets, noise, suspect)
        beyond = _is_beyond(places[suspect], places[others])
        if off_by < limit(others.size, places.shape[1]) or (
            beyond and _gap(fitted, places, targets, suspect) < GROSS
        ):
            break
        off[suspect], kept, processes = off_by, others, fitted
    return processes, off


def distance(
    processes: Processes, places: Matrix, targets: Matrix, noise: Matrix, index: int
) -> float:
    """Compute how far off an entry is that the processes do not know, in standard deviations."""
    found = []
    for process, wanted, known in zip(processes, targets, noise, strict=True):
        mean, deviation = process.predict(places[index])
        square = float(np.mean((wanted[index] - mean) ** 2))
        found.append(float(np.sqrt(square / (deviation**2 + known[index]))))
    return max(found)


def limit(entries: int, parameters: int) -> float:
    """Compute how many standard deviations off an entry disagrees with others.

    Args:
        entries: Number of the others.
        parameters: Number of parameters.
    """
    return student_factor(entries, parameters, DISAGREES) * DISAGREES


def _gap(processes: Processes, places: Matrix, targets: Matrix, index: int) -> float:
    """Compute how far off an entry is that the processes do not know, RMS, in its own unit."""
    return max(
        float(np.sqrt(np.mean((wanted[index] - process.predict(places[index])[0]) ** 2)))
        for process, wanted in zip(processes, targets, strict=True)
    )


def _is_beyond(place: Vector, others: Matrix) -> bool:
    low, high = others.min(axis=0) - MARGIN, others.max(axis=0) + MARGIN
    return bool(np.any((place < low) | (place > high)))


def _unexpected(processes: Processes) -> Vector:
    """Compute how far off each entry is if the others keep the hyperparameters, (n,)."""
    found = []
    for process in processes:
        residuals, deviations = leave_one_out(*process.known)
        found.append(np.sqrt(np.mean(residuals**2, axis=1)) / deviations)
    return np.asarray(np.max(found, axis=0))
