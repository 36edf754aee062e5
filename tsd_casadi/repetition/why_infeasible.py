"""Which limits contradict each other at a run's first infeasible tick."""

from __future__ import annotations

import numpy as np

from tsd_casadi.explanation.conflict_sentence import tell_conflict
from tsd_casadi.repetition.run import Run
from tsd_casadi.tick.format import Status


def why_infeasible(run: Run) -> str:
    """Say it in one sentence, from what the controller answered.

    Returns:
        The sentence, empty if no tick was infeasible because of limits.
    """
    if not run.conflict:
        return ""
    tick = int(np.argmax(run.log["status"] == Status.INFEASIBLE))
    return (
        f"tick {tick}, at {run.log['time'][tick]:.3f} s, was the first without a solution: "
        f"{tell_conflict(run.conflict)}"
    )
