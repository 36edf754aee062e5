"""From the run of a repetition to a recording for the learner."""

from __future__ import annotations

from typing import Any

from tsd_casadi.exceptions import SimulationError
from tsd_casadi.learning.circumstances import Circumstances
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.recording import Recording
from tsd_casadi.repetition.allowed_acceleration import allowed_accelerations
from tsd_casadi.repetition.run import Run
from tsd_casadi.repetition.what_to_try import what_to_try
from tsd_casadi.repetition.why_infeasible import why_infeasible
from tsd_casadi.robot.robot import Robot
from tsd_casadi.version import __version__


def record_of(
    run: Run,
    robot: Robot,
    correction: str = "",
) -> Recording:
    """Record what a run leaves behind for learning: its steady laps.

    Args:
        robot: As its controller believes it.
        correction: Fingerprint of the estimated centre of mass; empty for none.

    Raises:
        SimulationError: If it fell or never settled.
    """
    what = " ".join(f"{name}={value:g}" for name, value in run.motion.parameters.items())
    if run.fell or run.failures or not run.steady:
        how = (
            "fell"
            if run.fell
            else "needed safe torques"
            if run.failures
            else f"did not settle in {run.laps_run} laps"
        )
        told = [*what_to_try(run), why_infeasible(run)]
        raise SimulationError(
            f"the robot {how} in {run.motion.name} {what}; nothing was recorded. "
            + "; ".join(sentence for sentence in told if sentence)
        )
    return Recording(
        key=EntryKey.of(
            run.robot,
            run.motion.name,
            run.motion.version,
            run.feedforward.axes,
            run.motion.parameters,
            context_of(robot, correction),
        ),
        basis=run.feedforward.basis,
        applied=run.feedforward.weights,
        laps=run.laps,
        errors=run.errors,
        circumstances=Circumstances(
            run.gains,
            _setting(run),
            __version__,
            allowed_accelerations(robot, run.motion, run.feedforward.axes),
        ),
        declaration=run.motion.declaration(),
    )


def _setting(run: Run) -> dict[str, Any]:
    """Tell of the entry what it should say: joints that met their stops, too."""
    return {**run.settings, "at_limits": run.at_limits} if run.at_limits else run.settings


def context_of(robot: Robot, correction: str = "") -> Context:
    """Tell in which context something is learned on a robot.

    Args:
        robot: As its controller believes it.
        correction: Fingerprint of the estimated centre of mass; empty for none.
    """
    return Context(robot.body_fingerprint, robot.formulation_fingerprint, correction)
