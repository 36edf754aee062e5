"""Repeating and learning, where the user says or where it teaches most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

import typer

from tsd_casadi.exceptions import EntryNotFound, InvalidValue, TsdError
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.learning.rules.by_name import find_rule
from tsd_casadi.learning.rules.rule import Rule
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.learn import learn
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_cli.actions.label import label_of
from tsd_cli.actions.prepare import (
    asked_motion,
    chosen_compensators,
    chosen_gains,
    make_motion,
    make_simulator,
    open_controller,
    open_learner,
)
from tsd_cli.actions.region import describe_chosen, read_region
from tsd_cli.interrupt import interruptible
from tsd_cli.options.learning import FirstChoice, LearningOptions, PlaceOptions
from tsd_cli.options.motion import MotionOptions, RepetitionOptions
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.robot import SimulatedRobotOptions
from tsd_cli.options.services import ServiceOptions
from tsd_cli.output import check_outputs, put_out
from tsd_clients.console.learner_tables import print_contractions, print_places
from tsd_clients.console.progress import show_progress
from tsd_clients.console.run_tables import print_runs
from tsd_clients.remote.remote_learner import RemoteLearner


@interruptible("what was recorded before is kept")
def learn_by_repetition(
    motion: MotionOptions,
    learning: LearningOptions,
    places: PlaceOptions,
    repetition: RepetitionOptions,
    body: SimulatedRobotOptions,
    services: ServiceOptions,
    output: JsonOptions,
) -> None:
    """Learn at one place or at several, and show how it went.

    Raises:
        TsdError: If it cannot be done as asked; what was learned before is shown.
    """
    check_outputs(output)
    robot = load_robot(body.robot)
    wanted = asked_motion(motion, robot)
    if learning.iterations < 1:
        raise InvalidValue("iterations", learning.iterations, "at least 1")
    if places.region and not places.auto:
        raise InvalidValue("--region", ", ".join(places.region), "--auto with it")
    region = read_region(places.region or ["amplitude"], robot)
    gains = chosen_gains(repetition)
    compensators = chosen_compensators(repetition, robot)
    simulator = make_simulator(body, robot)
    rule = find_rule(learning.rule.value)
    if places.auto:
        for line in describe_chosen(places.region or ["amplitude"], region):
            typer.echo(f"note: {line}", err=True)
    story = _Story()
    failure: TsdError | None = None
    runs = (learning.iterations + 1.0) * max(places.auto, 1)
    with (
        open_learner(services) as learner,
        open_controller(services, robot) as controller,
        show_progress(f"learning {wanted.name}", runs) as progress,
    ):

        def progress_of(_: Motion, __: int) -> Any:
            before = len(story.summaries)
            return lambda done, total: progress(before + done / total, runs)

        learn_at = partial(
            learn,
            simulator,
            controller,
            learner=learner,
            iterations=learning.iterations,
            patience=rule.patience if learning.patience is None else learning.patience,
            restart=learning.restart,
            rule=rule.name,
            laps=repetition.laps,
            gains=gains,
            compensators=compensators,
            seed=repetition.seed,
            transport=services.controller.value,
            progress=progress_of,
            on_run=story.keep_run,
            on_learned=story.keep_contractions,
        )
        first = partial(_ask_first, learning.first, learner, robot)
        if not places.auto:
            learn_at([wanted], first=first(wanted))
        fixed = {name: value for name, value in wanted.parameters.items() if name not in region}
        for _ in range(places.auto):
            before = len(story.summaries)
            try:
                place = learner.suggest(wanted.name, robot=robot.name, region=region, **fixed)
            except TsdError as error:
                failure = error
                break
            if failure is not None and place.parameters == story.places[-1]["parameters"]:
                break  # where nothing can be learned
            try:
                there = make_motion(wanted.name, **place.parameters)
                learn_at([there], first=first(there))
            except TsdError as error:
                failure = error  # shown after what was learned before it
            errors = [summary["rms_error_m"] for summary in story.summaries[before:]]
            story.places.append({**asdict(place), "rms_errors_m": errors})
    result = {"robot": robot.name, "task": wanted.name, **story.plain()}
    put_out(result, output, lambda: story.show(wanted.name, rule, places))
    if failure is not None:
        raise failure


class _Story:
    """What happened while learning, in order."""

    def __init__(self) -> None:
        self.summaries: list[dict[str, Any]] = []
        self.places: list[dict[str, Any]] = []
        self._learned: list[tuple[Motion, Sequence[Contraction]]] = []

    def keep_run(self, run: Run, notes: list[str]) -> None:
        self.summaries.append({"label": label_of(run), **run.summary(), "notes": notes})
        for note in notes:
            typer.echo(f"note: {note}", err=True)

    def keep_contractions(self, motion: Motion, contractions: Sequence[Contraction]) -> None:
        self._learned.append((motion, contractions))

    def plain(self) -> dict[str, Any]:
        return {
            "runs": self.summaries,
            "places": self.places,
            "contractions": [
                {"parameters": motion.parameters, **asdict(each)}
                for motion, contractions in self._learned
                for each in contractions
            ],
        }

    def show(self, motion: str, rule: Rule, places: PlaceOptions) -> None:
        if places.auto:
            print_places(motion, self.places)
        else:
            print_runs(f"learning {motion}", self.summaries)
        if rule.is_by_harmonic:
            for at, contractions in self._learned:
                print_contractions(motion, at.parameters, contractions)


def _ask_first(
    choice: FirstChoice, learner: RemoteLearner, robot: Robot, motion: Motion
) -> Feedforward | None:
    """Choose what a motion of which nothing is known starts with."""
    if choice is FirstChoice.NONE:
        return None
    try:
        return learner.query(
            motion.name, robot=robot.name, kind=choice.value, extrapolate=True, **motion.parameters
        )
    except EntryNotFound as error:
        typer.echo(f"note: nothing to generalise from yet ({error})", err=True)
        return None
