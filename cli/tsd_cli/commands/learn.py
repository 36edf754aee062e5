"""'tsd learn': repeat and learn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from typing import Annotated, Any

import typer

from tsd_casadi.exceptions import InvalidValue, TsdError
from tsd_casadi.learning.contraction import Contraction
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.repetition.learn import learn as learn_motions
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_casadi.wire.endpoints import LEARNER
from tsd_cli.commands.options import (
    ROBOT,
    AmplitudeOption,
    ComCorrectionOption,
    ConnectOption,
    ControllerChoice,
    ControllerOption,
    DScaleOption,
    FirstChoice,
    FrequencyOption,
    HardwareOption,
    HeightOption,
    JsonOption,
    LapsOption,
    LinkErrorOption,
    LinkSeedOption,
    ModelErrorOption,
    MotionArgument,
    PScaleOption,
    RobotOption,
    RuleChoice,
    SeedOption,
    make_motion,
    make_simulator,
    open_controller,
    read_compensators,
)
from tsd_cli.commands.output import check_writable, label_of, put_out
from tsd_cli.commands.region import parse_region
from tsd_clients.console.progress import show_progress
from tsd_clients.console.tables import print_contractions, print_places, print_runs
from tsd_clients.remote.remote_learner import RemoteLearner

# iterations without progress after which stable learning has converged
PATIENCE = 3


def learn(
    motion: MotionArgument,
    iterations: Annotated[
        int, typer.Option("--iterations", help="N iterations are N + 1 runs, the last evaluates.")
    ] = 1,
    restart: Annotated[
        bool, typer.Option("--restart", help="Forget what was learned of this motion first.")
    ] = False,
    rule: Annotated[
        RuleChoice,
        typer.Option(
            "--rule",
            help="plain: the paper's sum. guarded: the same, never going on from what proved "
            "worse. stable: guarded, with phase lead and bandwidth from the response that the "
            "repetitions show, so that lag and delay let nothing grow; prints by harmonic what "
            "an iteration leaves of the error.",
        ),
    ] = RuleChoice.GUARDED,
    patience: Annotated[
        int | None,
        typer.Option(
            "--patience",
            min=1,
            help="Stop after so many iterations in a row without a smaller error. Default: "
            f"{PATIENCE} with --rule stable, else never.",
        ),
    ] = None,
    first: Annotated[
        FirstChoice,
        typer.Option(
            "--first",
            help="What a motion of which nothing is known starts with; generalised is the "
            "learner's regression, extrapolated if need be and dropped if it harms.",
        ),
    ] = FirstChoice.NONE,
    auto: Annotated[
        int,
        typer.Option(
            "--auto",
            min=0,
            help="Learn at so many places of the region, each time where the learner is most "
            "uncertain, instead of at the one given.",
        ),
    ] = 0,
    region: Annotated[
        list[str] | None,
        typer.Option(
            "--region",
            help="Range to choose from, as amplitude=0.02:0.08, or a name for the robot's whole "
            "range; repeat for more parameters. Default: amplitude.",
        ),
    ] = None,
    robot: RobotOption = ROBOT,
    amplitude: AmplitudeOption = 0.03,
    frequency: FrequencyOption = 0.25,
    laps: LapsOption = 3,
    height: HeightOption = 0.0,
    p_scale: PScaleOption = 1.0,
    d_scale: DScaleOption = 1.0,
    model_error: ModelErrorOption = 0.0,
    link_error: LinkErrorOption = 0.0,
    link_seed: LinkSeedOption = 0,
    hardware: HardwareOption = "",
    com_correction: ComCorrectionOption = None,
    controller: ControllerOption = ControllerChoice.ZENOH,
    connect: ConnectOption = None,
    seed: SeedOption = 0,
    json_file: JsonOption = None,
) -> None:
    """Learn a motion's feedforward by repeating it; continues an existing entry.

    With --auto N the learner says where, N times: where its feedforward is most
    uncertain.
    """
    check_writable(json_file)
    loaded = load_robot(robot)
    wanted = make_motion(motion, amplitude, frequency, height)
    wanted.check(loaded)
    if iterations < 1:
        raise InvalidValue("iterations", iterations, "at least 1")
    compensators = read_compensators(loaded, com_correction)
    simulator = make_simulator(loaded, model_error, link_error, link_seed, hardware)
    if region and not auto:
        raise InvalidValue("--region", ", ".join(region), "--auto with it")
    ranges = parse_region(region or ["amplitude"], loaded)
    summaries: list[dict[str, Any]] = []
    places: list[dict[str, Any]] = []
    learned: list[tuple[Motion, Sequence[Contraction]]] = []
    if patience is None and rule is RuleChoice.STABLE:
        patience = PATIENCE

    def keep(run: Run, notes: list[str]) -> None:
        summaries.append({"label": label_of(run), **run.summary(), "notes": notes})
        for note in notes:
            typer.echo(f"note: {note}", err=True)

    runs = (iterations + 1.0) * max(auto, 1)
    failure: TsdError | None = None
    with (
        RemoteLearner(connect or [LEARNER]) as remote,
        open_controller(controller, loaded, connect) as opened,
        show_progress(f"learning {motion}", runs) as progress,
    ):

        def progress_of(_: Motion, __: int) -> Any:
            before = len(summaries)
            return lambda done, total: progress(before + done / total, runs)

        learn_at = partial(
            learn_motions,
            simulator,
            opened,
            learner=remote,
            iterations=iterations,
            patience=patience,
            restart=restart,
            rule=rule.value,
            laps=laps,
            gains=Gains(p_scale, d_scale),
            compensators=compensators,
            seed=seed,
            transport=controller.value,
            progress=progress_of,
            on_run=keep,
            on_learned=lambda at, contractions: learned.append((at, contractions)),
        )
        if not auto:
            learn_at([wanted], first=_first_feedforward(first, remote, loaded, wanted))
        fixed = {name: value for name, value in wanted.parameters.items() if name not in ranges}
        for _ in range(auto):
            before = len(summaries)
            try:
                place = remote.suggest(motion, robot=loaded.name, region=ranges, **fixed)
            except TsdError as error:
                failure = error
                break
            if failure is not None and place.parameters == places[-1]["parameters"]:
                break  # where nothing can be learned
            try:
                there = make_motion(motion, **place.parameters)
                learn_at([there], first=_first_feedforward(first, remote, loaded, there))
            except TsdError as error:
                failure = error  # shown after what was learned before it
            errors = [summary["rms_error_m"] for summary in summaries[before:]]
            places.append({**asdict(place), "rms_errors_m": errors})
    result = {
        "robot": loaded.name,
        "task": motion,
        "runs": summaries,
        "places": places,
        "contractions": [
            {"parameters": at.parameters, **asdict(each)}
            for at, all_axes in learned
            for each in all_axes
        ],
    }

    def show() -> None:
        if auto:
            print_places(motion, places)
        else:
            print_runs(f"learning {motion}", summaries)
        if rule is RuleChoice.STABLE:
            for at, contractions in learned:
                print_contractions(motion, at.parameters, contractions)

    put_out(result, json_file, show)
    if failure is not None:
        raise failure


def _first_feedforward(
    choice: FirstChoice, learner: RemoteLearner, robot: Robot, motion: Motion
) -> Feedforward | None:
    if choice is FirstChoice.NONE:
        return None
    try:
        return learner.query(
            motion.name,
            robot=robot.name,
            kind=choice.value,
            extrapolate=True,
            **motion.parameters,
        )
    except TsdError as error:
        if error.code != "not_found":
            raise
        typer.echo(f"note: nothing to generalise from yet ({error})", err=True)
        return None
