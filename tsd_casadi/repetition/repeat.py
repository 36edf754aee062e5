"""Do one repetition of a motion, from standing still to steady laps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack

from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.motion import Motion
from tsd_casadi.motions.ranges import check_motion
from tsd_casadi.repetition.compensator import Compensator
from tsd_casadi.repetition.gains import UNCHANGED, Gains
from tsd_casadi.repetition.observer import Observer
from tsd_casadi.repetition.pace import Pace
from tsd_casadi.repetition.plant import Plant
from tsd_casadi.repetition.repetition import Progress, Repetition
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot


def usual_axes(robot: Robot, motion: Motion) -> tuple[str, ...]:
    """List the axes that are learned if nobody says otherwise.

    Those that move and all of the centre of mass, since a wrong model moves
    every one of them.
    """
    tasks = robot.description.tasks
    com = [f"{task.name}.{axis}" for task in tasks if task.type == "com" for axis in task.axes]
    return tuple(dict.fromkeys((*motion.axes(robot), *com)))


def repeat(
    plant: Plant,
    controller: WholeBodyController,
    motion: Motion,
    *,
    axes: Sequence[str] | None = None,
    laps: int = 3,
    feedforward: Feedforward | None = None,
    gains: Gains = UNCHANGED,
    compensators: Sequence[Compensator] = (),
    observers: Sequence[Observer] = (),
    seed: int = 0,
    transport: str = "local",
    progress: Progress | None = None,
    pace: Pace | None = None,
    on_abort: Callable[[Run], None] | None = None,
) -> Run:
    """Do one repetition of a motion, in lock-step with a controller or against the clock.

    The robot holds the middle of the motion for one second with the feedforward
    of the starting phase, then moves. Laps are added until two consecutive ones
    agree, up to a bound.

    Args:
        plant: Simulated or real.
        controller: Local or remote.
        motion: What to do.
        axes: What is learned, 'task.axis'; see ``usual_axes``.
        laps: Least number of laps.
        feedforward: Learned term; none by default. Where it has fewer axes, it is
            zero along the others.
        gains: Factors on the gains of the learned tasks.
        compensators: What else changes commands and torques.
        observers: Who watches.
        seed: Of whatever is random about the plant.
        transport: How the controller is reached, for the records.
        progress: Called with (done, total) seconds of the repetition.
        pace: How fast by the clock; by default the plant waits for every answer.
        on_abort: Called with what was run if an error or the user ends it early, before
            that error goes on.

    Returns:
        The run.

    Raises:
        InvalidValue: If motion, axes or settings are out of range.
        UnknownField: If no task has one of the axes.
        SimulationError: If the controller serves another robot.
    """
    robot = plant.robot
    check_motion(robot, motion)
    if laps < 2:
        raise InvalidValue("laps", laps, "at least 2, the first one settles")
    learned = tuple(usual_axes(robot, motion) if axes is None else axes)
    if len(set(learned)) < len(learned) or not learned:
        raise InvalidValue("axes", ", ".join(learned) or "none", "at least one axis, none twice")
    repetition = Repetition(
        plant, controller, motion, learned, feedforward, gains, compensators, observers, pace
    )
    settings = {
        **plant.settings(),
        "period_s": plant.period,
        "p_scale": gains.P,
        "d_scale": gains.D,
        "transport": transport,
        "seed": seed,
        **({} if pace is None else {"pace": pace.factor}),
    }
    try:
        # whoever was told of the start is told of the end, whatever happens between them
        with ExitStack() as ends:
            for observer in observers:
                ends.callback(repetition.end, observer)
                observer.start(repetition.setting)
            plant.start(motion.middle(robot), seed)
            repetition.hold(progress)
            repetition.move(laps, progress)
            repetition.over = True
    except BaseException as error:
        if on_abort is not None and repetition.ticks:
            on_abort(repetition.finish(settings, str(error) or type(error).__name__))
        raise
    return repetition.finish(settings)
