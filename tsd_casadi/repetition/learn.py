"""Learning by repetition: run, record, run again with what was learned."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue, SimulationError, TsdError
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.recording import Context, Recording, Rule, TaskKey
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.compensator import Compensator
from tsd_casadi.repetition.feedforward_gate import FeedforwardGate
from tsd_casadi.repetition.gains import UNCHANGED, Gains
from tsd_casadi.repetition.repetition import Progress
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot
from tsd_casadi.version import __version__

# of the error: smaller gains are not worth another repetition
WORTHWHILE = 0.02


class Simulator(Protocol):
    """Something that can repeat a motion."""

    @property
    def robot(self) -> Robot:
        """The robot as its files describe it."""

    def run(
        self,
        controller: WholeBodyController,
        motion: Motion,
        *,
        laps: int,
        feedforward: Feedforward | None,
        gains: Gains,
        compensators: Sequence[Compensator],
        seed: int,
        transport: str,
        progress: Progress | None,
    ) -> Run:
        """One repetition, from standing still to steady laps."""


class Learned(Protocol):
    """An entry of a database, or the message that describes it."""

    @property
    def contractions(self) -> Sequence[Contraction]:
        """What iterations leave of an error, by axis."""


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

    def record(self, recording: Recording) -> tuple[Learned, list[str]]:
        """Take in one repetition."""


def learn(
    simulator: Simulator,
    controller: WholeBodyController,
    motions: Sequence[Motion],
    learner: Learner,
    *,
    iterations: int = 1,
    patience: int | None = None,
    first: Feedforward | None = None,
    restart: bool = False,
    rule: Rule = "guarded",
    laps: int = 3,
    gains: Gains = UNCHANGED,
    compensators: Sequence[Compensator] = (),
    seed: int | Sequence[int] = 0,
    transport: str = "local",
    progress: Callable[[Motion, int], Progress | None] | None = None,
    on_run: Callable[[Run, list[str]], None] | None = None,
    on_learned: Callable[[Motion, Sequence[Contraction]], None] | None = None,
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
        patience: Stop a motion after so many iterations in a row without an
            error that is noticeably smaller; never by default.
        first: Feedforward to start a motion from of which nothing is known,
            for instance that of an easier one; it is dropped if it harms.
        restart: Forget what was learned of each motion first.
        rule: See ``tsd_casadi.learning.recording.Recording``.
        laps: Least number of laps of each run.
        gains: Factors on the learned task's gains.
        compensators: What else changes commands and torques.
        seed: Of the starting posture and the sensors' noise: one for all
            repetitions, or one for each of a motion's N + 1 runs.
        transport: How the controller is reached, for the records.
        progress: Gives the progress function of a run, from motion and number.
        on_run: Called after each run with the learner's remarks.
        on_learned: Called after each motion with what iterations leave of its
            error.

    Returns:
        All runs in order.

    Raises:
        InvalidValue: If iterations or patience is not at least 1, or seeds are
            missing.
        SimulationError: If the robot fell or the feedback never settled; what
            was recorded before stays.
    """
    if iterations < 1:
        raise InvalidValue("iterations", iterations, "at least 1")
    if patience is not None and patience < 1:
        raise InvalidValue("patience", patience, "at least 1, or none")
    seeds = [seed] * (iterations + 1) if isinstance(seed, int) else list(seed)
    if len(seeds) != iterations + 1:
        raise InvalidValue("seeds", len(seeds), f"one, or one for each of {iterations + 1} runs")
    for motion in motions:
        motion.check(simulator.robot)
    runs = []
    for motion in motions:
        errors: list[float] = []
        for index in range(iterations + 1):
            fresh = restart and index == 0
            feedforward = None if fresh else _served(learner, simulator.robot.name, motion)
            gate = FeedforwardGate()
            gates = []
            if index == 0 and feedforward is None and first is not None:
                feedforward, gates = first, [gate]
            run = simulator.run(
                controller,
                motion,
                laps=laps,
                feedforward=feedforward,
                gains=gains,
                # the gate before what adds to the feedforward: it is about the borrowed one
                compensators=[*gates, *compensators],
                seed=seeds[index],
                transport=transport,
                progress=progress(motion, index) if progress is not None else None,
            )
            errors.append(run.rms_error)
            is_last = index == iterations or _has_converged(errors, patience)
            recording = record_of(
                run,
                simulator,
                controller,
                rule=rule,
                # what nobody is going to test is not served
                update=not is_last,
                restart=fresh,
            )
            entry, notes = learner.record(recording)
            if gate.dropped_at is not None:
                notes = [
                    f"the first feedforward was dropped at {gate.dropped_at:.2f} s: tracking was "
                    "worse with it than without",
                    *notes,
                ]
            if on_run is not None:
                on_run(run, notes)
            runs.append(run)
            if is_last:
                break
        if on_learned is not None:
            on_learned(motion, entry.contractions)
    return runs


def _has_converged(errors: list[float], patience: int | None) -> bool:
    """Whether the last repetitions brought nothing beyond the best one before them."""
    if patience is None or len(errors) <= patience + 1:
        return False
    return min(errors[-patience:]) > (1 - WORTHWHILE) * min(errors[:-patience])


def record_of(
    run: Run,
    simulator: Simulator,
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
            gains=_learned_gains(run, controller),
            version=__version__,
        ),
        rule=rule,
        update=update,
        restart=restart,
    )


def _learned_gains(run: Run, controller: WholeBodyController) -> dict[str, Any]:
    """P and D of the learned axes, W of the whole task."""
    components = [
        controller.format.component_index(*axis.split(".")) for axis in run.feedforward.axes
    ]
    learned = {name: [run.gains[name][i] for i in components] for name in ("P", "D")}
    return {**learned, "W": run.gains["W"]}


def _served(learner: Learner, robot: str, motion: Motion) -> Feedforward | None:
    try:
        return learner.query(
            motion.name, robot=robot, kind="learned", extrapolate=False, **motion.parameters
        )
    except TsdError as error:
        if error.code != "not_found":
            raise
        return None
