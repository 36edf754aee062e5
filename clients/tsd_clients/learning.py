"""Learning by repetition: run, record, run again with what was learned."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import tsd_casadi
from tsd_casadi.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue, SimulationError, TsdError
from tsd_casadi.feedforward import Feedforward
from tsd_casadi.motions import Motion
from tsd_casadi.recording import Context, Recording, Rule, TaskKey
from tsd_clients.repetition import Progress
from tsd_clients.run import Run
from tsd_clients.simulator import MujocoSimulator


class Learner(Protocol):
    """A database, local or behind a service."""

    def query(
        self,
        task: str,
        *,
        robot: str,
        kind: str | None = None,
        extrapolate: bool = False,
        **parameters: float,
    ) -> Feedforward:
        """The feedforward for some task parameters."""

    def record(self, recording: Recording) -> tuple[Any, list[str]]:
        """Take in one repetition."""


def learn(
    simulator: MujocoSimulator,
    controller: WholeBodyController,
    motions: Sequence[Motion],
    learner: Learner,
    *,
    iterations: int = 1,
    restart: bool = False,
    rule: Rule = "guarded",
    laps: int = 3,
    p_scale: float = 1.0,
    seed: int = 0,
    transport: str = "local",
    progress: Callable[[Motion, int], Progress | None] | None = None,
    on_run: Callable[[Run, list[str]], None] | None = None,
) -> list[Run]:
    """Repeat each motion, learning from one repetition to the next.

    N iterations are N + 1 runs: the last one only shows, and notes in the
    database, how well the newest feedforward does. An entry that exists is
    continued.

    Args:
        simulator: The simulated robot.
        controller: Local or remote.
        motions: What to learn, one after another.
        learner: Database or learner service.
        iterations: Learning iterations for each motion.
        restart: Forget what was learned of each motion first.
        rule: 'guarded' never goes on from what proved worse, 'plain' is the
            paper's sum.
        laps: Least number of laps of each run.
        p_scale: Factor on the learned task's P.
        seed: Of the starting randomness.
        transport: How the controller is reached, for the records.
        progress: Gives the progress function of a run, from motion and number.
        on_run: Called after each run with the learner's remarks.

    Returns:
        All runs in order.

    Raises:
        InvalidValue: If iterations is not at least 1.
        SimulationError: If the robot fell or the feedback never settled; what
            was recorded before stays.
    """
    if iterations < 1:
        raise InvalidValue("iterations", iterations, "at least 1")
    for motion in motions:
        motion.check(simulator.robot)
    runs = []
    for motion in motions:
        for index in range(iterations + 1):
            fresh = restart and index == 0
            feedforward = None if fresh else _served(learner, simulator.robot.name, motion)
            run = simulator.run(
                controller,
                motion,
                laps=laps,
                feedforward=feedforward,
                p_scale=p_scale,
                seed=seed,
                transport=transport,
                progress=progress(motion, index) if progress is not None else None,
            )
            recording = record_of(
                run,
                simulator,
                controller,
                rule=rule,
                update=index < iterations,
                restart=fresh,
            )
            _, notes = learner.record(recording)
            if on_run is not None:
                on_run(run, notes)
            runs.append(run)
    return runs


def record_of(
    run: Run,
    simulator: MujocoSimulator,
    controller: WholeBodyController,
    *,
    rule: Rule = "guarded",
    update: bool = True,
    restart: bool = False,
) -> Recording:
    """What a run leaves behind for learning.

    Args:
        run: The run.
        simulator: What it ran on.
        controller: What controlled it.
        rule: See ``learn``.
        update: False to note the errors only.
        restart: Forget the entry first.

    Returns:
        The recording of its steady laps.

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
        key=TaskKey.of(run.robot, run.motion.name, run.feedforward.axes, run.motion.parameters),
        basis=run.feedforward.basis,
        applied=run.feedforward.weights,
        laps=run.laps,
        errors=run.errors(),
        context=Context(
            formulation=f"{controller.format.layout_hash:016x}",
            model=simulator.robot.fingerprint,
            gains=run.gains,
            version=tsd_casadi.__version__,
        ),
        rule=rule,
        update=update,
        restart=restart,
    )


def _served(learner: Learner, robot: str, motion: Motion) -> Feedforward | None:
    try:
        return learner.query(
            motion.name, robot=robot, kind="learned", extrapolate=False, **motion.parameters
        )
    except TsdError as error:
        if error.code != "not_found":
            raise
        return None
