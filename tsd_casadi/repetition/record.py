"""From the run of a repetition to a recording for the learner."""

from __future__ import annotations

from typing import Any

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import SimulationError
from tsd_casadi.learning.entry_key import EntryKey
from tsd_casadi.learning.recording import Context, Recording
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_casadi.version import __version__


def record_of(
    run: Run,
    robot: Robot,
    controller: WholeBodyController,
) -> Recording:
    """Record what a run leaves behind for learning: its steady laps.

    Args:
        robot: As its controller believes it.

    Raises:
        SimulationError: If it fell or never settled.
    """
    what = " ".join(f"{name}={value:g}" for name, value in run.motion.parameters.items())
    if run.fell:
        raise SimulationError(
            f"the robot fell in {run.motion.name} {what}; nothing was recorded. Try a smaller "
            "motion, a smaller model error or a larger P"
        )
    if run.failures:
        kinds = ", ".join(f"{count} {kind}" for kind, count in run.failures.items())
        raise SimulationError(
            f"the controller answered ticks of {run.motion.name} {what} with a safe torque "
            f"({kinds}); nothing was recorded. Look at limits, weights and friction"
        )
    if not run.steady:
        raise SimulationError(
            f"the feedback of {run.motion.name} {what} did not settle in {run.laps_run} laps; "
            "nothing was recorded. Try a larger P or a slower motion"
        )
    return Recording(
        key=EntryKey.of(run.robot, run.motion.name, run.feedforward.axes, run.motion.parameters),
        basis=run.feedforward.basis,
        applied=run.feedforward.weights,
        laps=run.laps,
        errors=run.errors(),
        context=Context(
            formulation=f"{controller.format.layout_hash:016x}",
            model=robot.fingerprint,
            gains=_learned_gains(run, controller),
            version=__version__,
        ),
    )


def _learned_gains(run: Run, controller: WholeBodyController) -> dict[str, Any]:
    """Pick P and D of the learned axes, W of the whole task."""
    components = [
        controller.format.component_index(*axis.split(".")) for axis in run.feedforward.axes
    ]
    learned = {name: [run.gains[name][i] for i in components] for name in ("P", "D")}
    return {**learned, "W": run.gains["W"]}
