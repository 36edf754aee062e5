"""Which limits contradict each other at a run's first infeasible tick."""

from __future__ import annotations

import numpy as np

from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_casadi.tick.format import Status


def why_infeasible(run: Run, robot: Robot) -> str:
    """Say it in one sentence, from the request that had no solution; takes seconds.

    Args:
        robot: As its controller believes it.

    Returns:
        The sentence, empty if no tick was infeasible.
    """
    if run.infeasible_request is None:
        return ""
    # CasADi's part of the problem is needed by nobody whose limits agree
    from tsd_casadi.explanation.explain import explain
    from tsd_casadi.formulation.inverse_dynamics import InverseDynamics

    tick = int(np.argmax(run.log["status"] == Status.INFEASIBLE))
    explanation = explain(InverseDynamics(robot), run.infeasible_request)
    return (
        f"tick {tick}, at {run.log['time'][tick]:.3f} s, was the first without a solution: "
        f"{explanation.sentence()}"
    )
