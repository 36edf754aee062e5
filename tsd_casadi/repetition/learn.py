"""Learning by repetition: move, record, move again with what was learned."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import EntryNotFound, InvalidValue
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.feedforward_source import FeedforwardSource
from tsd_casadi.learning.instruction import Instruction
from tsd_casadi.learning.recording import Recording
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.learning.rules.rule import RuleName
from tsd_casadi.motions.motion import Motion
from tsd_casadi.motions.ranges import check_motion
from tsd_casadi.repetition.borrowed import gates_for
from tsd_casadi.repetition.compensator import Compensator
from tsd_casadi.repetition.gains import UNCHANGED, Gains
from tsd_casadi.repetition.observer import Observer
from tsd_casadi.repetition.pace import Pace
from tsd_casadi.repetition.plant import Plant
from tsd_casadi.repetition.record import context_of, record_of
from tsd_casadi.repetition.repeat import repeat, usual_axes
from tsd_casadi.repetition.repetition import Progress
from tsd_casadi.repetition.run import Run
from tsd_casadi.repetition.what_to_try import what_to_try

# of the error: smaller gains are not worth another repetition
WORTHWHILE = 0.02


class Learned(Protocol):
    """An entry of a database, or the message that describes it."""

    @property
    def contractions(self) -> Sequence[Contraction]:
        """What iterations leave of an error, by axis."""


class Learner(FeedforwardSource, Protocol):
    """A database, local or behind a service."""

    def record(self, recording: Recording, instruction: Instruction) -> tuple[Learned, list[str]]:
        """Take in one repetition, and learn from it as told."""


def learn(
    plant: Plant,
    controller: WholeBodyController,
    motions: Sequence[Motion],
    learner: Learner,
    *,
    axes: Sequence[str] | None = None,
    iterations: int = 1,
    patience: int | None = None,
    first: Feedforward | None = None,
    restart: bool = False,
    rule: RuleName = "adaptive",
    laps: int = 3,
    gains: Gains = UNCHANGED,
    compensators: Sequence[Compensator] = (),
    observers: Sequence[Observer] = (),
    seed: int | Sequence[int] = 0,
    transport: str = "local",
    pace: Pace | None = None,
    progress: Callable[[Motion, int], Progress | None] | None = None,
    on_run: Callable[[Run, list[str]], None] | None = None,
    on_learned: Callable[[Motion, Sequence[Contraction]], None] | None = None,
    on_abort: Callable[[Run], None] | None = None,
) -> list[Run]:
    """Repeat each motion, learning from one repetition to the next.

    N iterations are N + 1 repetitions: the last one only shows, and notes in the
    database, how well the newest feedforward does. An entry that exists is
    continued.

    Args:
        motions: What to learn, one after another.
        learner: Database or learner service.
        axes: What is learned, 'task.axis'; see ``usual_axes``.
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
        pace: How fast by the clock; by default the plant waits for every answer.
        progress: Gives the progress function of a repetition, from motion and number.
        on_run: Called after each repetition with the learner's remarks.
        on_learned: Called after each motion with what iterations leave of its
            error.
        on_abort: Called with what was run of a repetition that something ended early, or
            that was not recorded.

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
        check_motion(plant.robot, motion)
    learned_of = [
        tuple(usual_axes(plant.robot, motion) if axes is None else axes) for motion in motions
    ]
    correction = "".join(item.correction for item in compensators)
    context = context_of(plant.robot, correction)
    runs = []
    for motion, learned in zip(motions, learned_of, strict=True):
        errors: list[float] = []
        epoch = None
        for index in range(iterations + 1):
            fresh = restart and index == 0
            feedforward = (
                None if fresh else _served(learner, plant.robot.name, motion, learned, context)
            )
            if feedforward is not None and epoch != (epoch := feedforward.epoch):
                # those of before are of another robot, but for the one that showed it
                errors = errors[-1:]
            if index == 0 and feedforward is None:
                feedforward = first
            gates = gates_for(feedforward, plant.robot, controller, motion, gains, correction)
            run = repeat(
                plant,
                controller,
                motion,
                axes=learned,
                laps=laps,
                feedforward=feedforward,
                gains=gains,
                # the gate before what adds to the feedforward: it is about the borrowed one
                compensators=[*gates, *compensators],
                observers=observers,
                seed=seeds[index],
                transport=transport,
                pace=pace,
                on_abort=on_abort,
                progress=progress(motion, index) if progress is not None else None,
            )
            errors.append(run.rank)
            is_last = index == iterations or _has_converged(errors, patience)
            # what nobody is going to test is not served
            instruction = Instruction(known_rule, update=not is_last, restart=fresh)
            try:
                recording = record_of(run, plant.robot, correction)
                entry, notes = learner.record(recording, instruction)
            except BaseException:
                # what was run is more than the reason why nobody took it
                if on_abort is not None:
                    on_abort(run)
                raise
            about_run = [*run.vetoes, *run.remarks, *what_to_try(run)]
            notes = [*about_run, *_about_axes(feedforward, learned), *notes]
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
    if patience is None or len(errors) <= patience:
        return False
    return min(errors[-patience:]) > (1 - WORTHWHILE) * min(errors[:-patience])


def _served(
    learner: Learner, robot: str, motion: Motion, axes: tuple[str, ...], context: Context
) -> Feedforward | None:
    try:
        return learner.query(
            motion.name,
            robot=robot,
            kind="learned",
            extrapolate=False,
            axes=axes,
            context=context,
            version=motion.version,
            **motion.parameters,
        )
    except EntryNotFound:
        return None


def _about_axes(feedforward: Feedforward | None, axes: Sequence[str]) -> list[str]:
    missing = [axis for axis in axes if feedforward is not None and axis not in feedforward.axes]
    return [f"nothing was learned along {', '.join(missing)} yet: zero there"] if missing else []
