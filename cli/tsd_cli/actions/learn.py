"""Repeating and learning, where the user says or where it teaches most."""

from __future__ import annotations

from functools import partial
from typing import Any

import typer

from tsd_casadi.exceptions import InvalidValue, TsdError
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.learn import learn
from tsd_casadi.repetition.record import context_of
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import load_robot
from tsd_cli.actions.aborted import ABORTED, FELL, put_out_on_interrupt
from tsd_cli.actions.film import Footage, open_viewer
from tsd_cli.actions.first_feedforward import ask_first
from tsd_cli.actions.open_learner import open_learner
from tsd_cli.actions.prepare import (
    asked_motion,
    chosen_axes,
    chosen_compensators,
    chosen_gains,
    chosen_pace,
    make_simulator,
    open_controller,
)
from tsd_cli.actions.region import default_name, describe_chosen, read_region
from tsd_cli.actions.story import Story
from tsd_cli.actions.watchable import watchable
from tsd_cli.interrupt import interruptible
from tsd_cli.options.film import FilmOptions
from tsd_cli.options.learning import LearningOptions, PlaceOptions
from tsd_cli.options.motion import MotionOptions, RepetitionOptions
from tsd_cli.options.output import LogOptions
from tsd_cli.options.pace import PaceOptions
from tsd_cli.options.robot import SimulatedRobotOptions
from tsd_cli.options.services import ServiceOptions
from tsd_cli.options.telemetry import TelemetryOptions
from tsd_cli.output import check_outputs, put_out
from tsd_clients.console.progress import show_progress
from tsd_clients.logs.log_file import check_log_path
from tsd_clients.logs.log_series import LogSeries
from tsd_clients.telemetry.telling_learner import TellingLearner


@interruptible("what was recorded before is kept")
def learn_by_repetition(
    motion: MotionOptions,
    learning: LearningOptions,
    places: PlaceOptions,
    repetition: RepetitionOptions,
    time: PaceOptions,
    body: SimulatedRobotOptions,
    services: ServiceOptions,
    film: FilmOptions,
    watching: TelemetryOptions,
    output: LogOptions,
) -> None:
    """Learn at one place or at several, and show how it went.

    Raises:
        TsdError: If it cannot be done as asked; what was learned before is shown.
        typer.Exit: If a repetition was ended early or the robot fell; what was run of it is
            shown, too.
    """
    check_outputs(output, output.log)
    if output.log is not None:
        check_log_path(output.log)
    robot = load_robot(body.robot)
    footage = Footage(film, robot)
    wanted = asked_motion(motion, robot)
    axes = chosen_axes(motion, robot, wanted)
    if learning.iterations < 1:
        raise InvalidValue("iterations", learning.iterations, "at least 1")
    if places.region and not places.auto:
        raise InvalidValue("--region", ", ".join(places.region), "--auto with it")
    asked_region = places.region or [default_name(type(wanted))]
    region = read_region(asked_region, robot, type(wanted)) if places.auto else {}
    gains, pace = chosen_gains(repetition), chosen_pace(time)
    compensators = chosen_compensators(repetition, robot)
    context = context_of(robot, "".join(item.correction for item in compensators))
    simulator = make_simulator(body, robot, repetition.period)
    rule = find_rule(learning.rule.value)
    if places.auto:
        for line in describe_chosen(asked_region, region, type(wanted)):
            typer.echo(f"note: {line}", err=True)
    story = Story()
    failure: TsdError | None = None
    told = {
        **simulator.settings(),
        "p_scale": gains.P,
        "d_scale": gains.D,
        "period_s": repetition.period,
        "seed": repetition.seed,
        "transport": services.controller.value,
        "pace": time.pace,
        "rule": rule.name,
        "iterations": learning.iterations,
    }
    logs = None if output.log is None else LogSeries(output.log, told)
    runs = (learning.iterations + 1.0) * max(places.auto, 1)

    def put_out_story() -> None:
        story.conclude(robot, axes, context.correction)
        result = {"robot": robot.name, "motion": wanted.name, "axes": list(axes), **story.plain()}
        if failure is None or story.summaries:
            put_out(result, output, lambda: story.show(wanted, rule, places))

    with (
        put_out_on_interrupt(put_out_story),
        watchable(watching, robot, told) as telemetry,
        open_learner(services) as learner,
        open_controller(services, robot, time.patience) as controller,
        show_progress(f"learning {wanted.name}", runs) as progress,
        open_viewer(film, robot) as viewer,
    ):

        def progress_of(_: Motion, __: int) -> Any:
            before = len(story.summaries)
            return lambda done, total: progress(before + done / total, runs)

        def keep_run(run: Run, notes: list[str]) -> None:
            story.keep_run(run, notes)
            footage.keep_last_lap(run)
            if logs is not None:
                logs.conclude(run)
            if telemetry is not None:
                telemetry.measured(run, notes)

        def keep_aborted(run: Run) -> None:
            story.keep_aborted(run)
            if logs is not None:
                logs.conclude(run)

        learn_at = partial(
            learn,
            simulator,
            controller,
            learner=learner if telemetry is None else TellingLearner(learner, telemetry),
            axes=axes,
            iterations=learning.iterations,
            patience=rule.patience if learning.stop_after is None else learning.stop_after,
            restart=learning.restart,
            rule=rule.name,
            laps=repetition.laps,
            gains=gains,
            compensators=compensators,
            observers=[each for each in (viewer, telemetry, logs) if each is not None],
            seed=repetition.seed,
            transport=services.controller.value,
            pace=pace,
            progress=progress_of,
            on_run=keep_run,
            on_learned=story.keep_contractions,
            on_abort=keep_aborted,
        )
        first = partial(ask_first, learning.first, learner, robot, axes, context)
        if not places.auto:
            try:
                learn_at([wanted], first=first(wanted))
            except TsdError as error:
                failure = error  # shown after what was run before it
        fixed = {name: value for name, value in wanted.parameters.items() if name not in region}
        for _ in range(places.auto):
            before = len(story.summaries)
            try:
                place = learner.suggest(
                    wanted.name,
                    robot=robot.name,
                    region=region,
                    axes=axes,
                    context=context,
                    version=wanted.version,
                    **fixed,
                )
            except TsdError as error:
                failure = error
                break
            if failure is not None and place.parameters == story.places[-1]["parameters"]:
                break  # where nothing can be learned
            try:
                there = type(wanted)(**place.parameters)
                learn_at([there], first=first(there))
            except TsdError as error:
                failure = error  # shown after what was learned before it
            story.keep_place(place, before)
    put_out_story()
    footage.make()
    if failure is not None and (story.was_aborted or story.fell):
        typer.echo(f"error: {failure}", err=True)
        raise typer.Exit(ABORTED if story.was_aborted else FELL)
    if failure is not None:
        raise failure
