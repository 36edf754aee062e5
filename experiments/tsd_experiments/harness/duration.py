"""How long the experiments took, however many sittings that were."""

from __future__ import annotations

from collections.abc import Iterable

# s; workers and services start between two jobs, and that belongs to the work
LONGEST_PAUSE = 30.0

Span = tuple[float, float]


def time_taken(spans: Iterable[Span]) -> float:
    """Compute how long at least one job was under way, short pauses included.

    Jobs that ran side by side count once, and what lies between an interrupted
    run and the one that went on from there does not count.

    Args:
        spans: Begin and end of each job [s], in any order.

    Returns:
        The time [s].
    """
    total, end = 0.0, -float("inf")
    for begin, stop in sorted(spans):
        if stop <= end:
            continue
        total += stop - (end if begin - end <= LONGEST_PAUSE else begin)
        end = stop
    return total
