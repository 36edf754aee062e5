"""Learning by repetition: move, record, move again with what was learned."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import EntryNotFound, InvalidValue
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.compensator import Compensator
from tsd_casadi.repetition.feedforward_gate import FeedforwardGate
from tsd_casadi.repetition.gains import UNCHANGED, Gains
from tsd_casadi.repetition.record import record_of
from tsd_casadi.repetition.repetition import Progress
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot

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
        """Repeat once, from standing still to steady laps."""


class Learned(Protocol):
    """An entry of a database, or the message that describes it."""

    @property
    def contractions(self) -> Sequence[Contraction]:
        """What iterations leave of an error, by axis."""


class Learner(Protocol):
    """A database, local or behind a service."""

    def query(
        self,
        motion: str,
        /,
        *,
        robot: str,
        kind: str | None = None,
        extrapolate: bool = False,
        **parameters: float,
    ) -> Feedforward:
        """Tell the feedforward for some parameters of a motion."""

    def record(self, recording: Recording, instruction: Instruction) -> tuple[Learned, list[str]]:
        """Take in one repetition, and learn from it as told."""


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
    rule: RuleName = "guarded",
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

    N iterations are N + 1 repetitions: the last one only shows, and notes in the
    database, how well the newest feedforward does. An entry that exists is
    continued.

    Args:
        motions: What to learn, one after another.
        learner: Database or learner service.
        iterations: Learning iterations for each motion.
        patience: Stop a motion after so many iterations in a row without an
            error that is noticeably smaller; never by default.
        first: Feedforward to start a motion from of which nothing is known,
            for instance that of an easier one; it is dropped if it harms.
        restart: Forget what was learned of each motion first.
        rule: How each entry goes on; see ``tsd_casadi.learning.rules``.
        laps: Least number of laps of each repetition.
        gains: Factors on the learned task's gains.
        seed: Of the starting posture and the sensors' noise: one for all
            repetitions, or one for each of a motion's N + 1.
        transport: How the controller is reached, for the records.
        progress: Gives the progress function of a repetition, from motion and number.
        on_run: Called after each repetition with the learner's remarks.
        on_learned: Called after each motion with what iterations leave of its
            error.

    Returns:
        The run of every repetition, in order.

    Raises:
        InvalidValue: If iterations or patience is not at least 1, seeds are
            missing, or there is no such rule.
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
    known_rule = find_rule(rule)
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
            # what nobody is going to test is not served
            instruction = Instruction(known_rule, update=not is_last, restart=fresh)
            recording = record_of(run, simulator.robot, controller)
            entry, notes = learner.record(recording, instruction)
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
    """Say whether the last repetitions brought nothing beyond the best one before."""
    if patience is None or len(errors) <= patience + 1:
        return False
    return min(errors[-patience:]) > (1 - WORTHWHILE) * min(errors[:-patience])


def _served(learner: Learner, robot: str, motion: Motion) -> Feedforward | None:
    try:
        return learner.query(
            motion.name, robot=robot, kind="learned", extrapolate=False, **motion.parameters
        )
    except EntryNotFound:
        return None
