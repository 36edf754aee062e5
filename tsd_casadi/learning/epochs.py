"""Iterations by epoch: those since the robot changed last, and those before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tsd_casadi.learning.iteration import Iteration
from tsd_casadi.learning.robot_change import Observation


def newest_epoch(iterations: Sequence[Iteration]) -> int:
    """Tell how often the robot has changed since the first iteration."""
    return max((item.epoch for item in iterations), default=0)


def since_change(iterations: Sequence[Iteration]) -> list[Iteration]:
    """List the iterations of the newest epoch, in their order."""
    epoch = newest_epoch(iterations)
    return [item for item in iterations if item.epoch == epoch]


def shows_change(
    iterations: Sequence[Iteration], used: Iteration, seen: Observation, gains: Mapping[str, Any]
) -> bool:
    """Say whether a repetition cannot be one of the robot of the newest epoch.

    Args:
        used: The iteration that it used, tested before or not.
        seen: What it showed.
        gains: At which it was made; at others robots of all kinds do otherwise.
    """
    if used.errors is not None:
        return used.gains == gains and seen.differs_from_test(used)
    parents = [item for item in since_change(iterations) if item.number == used.learned_from]
    return any(item.gains == gains and seen.differs_from_parent(item) for item in parents)


def hardware_of(iterations: Sequence[Iteration]) -> dict[str, Any]:
    """Tell of which hardware a simulation was in the newest epoch; nothing if nobody said.

    A test of which nobody said it, on a real robot for instance, does not hide the others.
    """
    tests = [item.circumstances for item in since_change(iterations) if item.circumstances]
    return next((made.hardware for made in reversed(tests) if made.hardware), {})


def is_other_hardware(before: Mapping[str, Any], now: Mapping[str, Any]) -> bool:
    """Say whether a simulation was told to be of another robot than in the newest epoch.

    Args:
        before: Hardware of the newest epoch; nothing if nobody said.
        now: That of the recording that is taken in.
    """
    return bool(before) and bool(now) and before != now


def recall(
    iterations: Sequence[Iteration], seen: Observation, gains: Mapping[str, Any]
) -> Iteration | None:
    """Find the best iteration of an earlier epoch in which the robot was as it is now.

    Args:
        seen: What the repetition showed with which the newest epoch begins.
        gains: At which it was made.
    """
    newest = newest_epoch(iterations)
    best: dict[int, Iteration] = {}
    for item in iterations:
        # the robot has just stopped being that of the epoch before
        if item.epoch < newest - 1 and item.gains == gains:
            known = best.get(item.epoch)
            best[item.epoch] = item if known is None or item.error < known.error else known
    nearest = min(best.values(), key=seen.distance_to, default=None)
    return nearest if nearest is not None and seen.distance_to(nearest) <= 1 else None


def about_rest(used: Iteration) -> str:
    """Tell people by what a change was noticed."""
    return (
        f"this is not the robot of before: iteration {used.number} left what neither noise nor "
        "learning explains"
    )


def about_hardware(before: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """Tell people which hardware a simulation has now and had before."""
    names = [name for name in {**before, **now} if before.get(name) != now.get(name)]
    had, has = ({name: each.get(name) for name in names} for each in (before, now))
    return f"this is not the hardware of before: {has} against {had}"


def about_change(why: str, used: Iteration, recalled: Iteration | None) -> str:
    """Tell people that the robot is taken for another one from now on.

    Args:
        why: By what it was noticed.
        used: The first iteration of the new epoch.
        recalled: What is taken again, if anything.
    """
    start = f"{why}. Epoch {used.epoch} starts from iteration {used.number}"
    if recalled is None:
        return f"{start}; errors of before count no more, the learning gain is 1 again"
    return (
        f"{start}; it is as in epoch {recalled.epoch}, of which iteration {recalled.number} is "
        "taken again"
    )
