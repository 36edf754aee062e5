"""One repetition of a motion in simulation, for the command line."""

from __future__ import annotations

import typer

from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.borrowed import gates_for
from tsd_casadi.repetition.record import context_of
from tsd_casadi.repetition.run import Run
from tsd_casadi.repetition.what_to_try import what_to_try
from tsd_casadi.repetition.why_infeasible import why_infeasible
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_cli.actions.aborted import FELL, keep_aborted
from tsd_cli.actions.film import Footage, open_viewer
from tsd_cli.actions.label import describe_motion, label_of
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
from tsd_cli.actions.watchable import watchable
from tsd_cli.interrupt import interruptible
from tsd_cli.options.film import FilmOptions
from tsd_cli.options.motion import FeedforwardChoice, MotionOptions, SingleRepetitionOptions
from tsd_cli.options.output import LogOptions
from tsd_cli.options.pace import PaceOptions
from tsd_cli.options.robot import SimulatedRobotOptions
from tsd_cli.options.services import ServiceOptions
from tsd_cli.options.telemetry import TelemetryOptions
from tsd_cli.output import STDOUT, check_outputs, put_out
from tsd_clients.console.progress import show_progress
from tsd_clients.console.run_tables import print_runs
from tsd_clients.logs.log_file import check_log_path
from tsd_clients.logs.run_log import RunLog, run_log


@interruptible()
def simulate_once(
    motion: MotionOptions,
    repetition: SingleRepetitionOptions,
    time: PaceOptions,
    body: SimulatedRobotOptions,
    services: ServiceOptions,
    film: FilmOptions,
    watching: TelemetryOptions,
    output: LogOptions,
) -> None:
    """Simulate a repetition and show how it went.

    Raises:
        TsdError: If it cannot be done as asked.
        typer.Exit: If the robot fell, or the run was ended early.
    """
    check_outputs(output, output.log)
    if output.log is not None:
        check_log_path(output.log)
    robot = load_robot(body.robot)
    footage = Footage(film, robot)
    wanted = asked_motion(motion, robot)
    axes = chosen_axes(motion, robot, wanted)
    gains, pace = chosen_gains(repetition), chosen_pace(time)
    compensators = chosen_compensators(repetition, robot)
    simulator = make_simulator(body, robot, repetition.period)
    correction = "".join(item.correction for item in compensators)
    learned = _ask(repetition.feedforward, robot, wanted, axes, correction, services)
    told = {
        **simulator.settings(),
        "p_scale": gains.P,
        "d_scale": gains.D,
        "period_s": repetition.period,
        "seed": repetition.seed,
        "transport": services.controller.value,
        "pace": time.pace,
        "feedforward": repetition.feedforward.value,
    }
    files = [str(file) for file in (output.log, output.json_file) if file not in (None, STDOUT)]
    log: RunLog | None = None

    def put_out_run(run: Run) -> None:
        _put_out(run, log, output)

    with (
        keep_aborted(put_out_run, files) as keep,
        watchable(watching, robot, told) as telemetry,
        open_controller(services, robot, time.patience) as controller,
        show_progress(describe_motion(wanted), 1.0) as progress,
        open_viewer(film, robot) as viewer,
    ):
        gates = gates_for(learned, robot, controller, wanted, gains, correction)
        # the gate before what adds to the feedforward: it is about the borrowed one
        compensators = [*gates, *compensators]
        log = None if output.log is None else run_log(output.log, compensators, told)
        run = simulator.run(
            controller,
            wanted,
            axes=axes,
            laps=repetition.laps,
            feedforward=learned,
            gains=gains,
            compensators=compensators,
            observers=[each for each in (viewer, telemetry, log) if each is not None],
            seed=repetition.seed,
            transport=services.controller.value,
            progress=progress,
            pace=pace,
            on_abort=keep,
        )
        if telemetry is not None:
            telemetry.measured(run, what_to_try(run))
    for note in (*run.vetoes, *run.remarks, *what_to_try(run)):
        typer.echo(f"note: {note}", err=True)
    if why := why_infeasible(run):
        typer.echo(f"note: {why}", err=True)
    missing = [] if learned is None else [axis for axis in axes if axis not in learned.axes]
    if missing:
        typer.echo(
            f"note: nothing was learned along {', '.join(missing)} yet: zero there", err=True
        )
    put_out_run(run)
    footage.keep(run)
    footage.make()
    if run.fell:
        raise typer.Exit(FELL)


def _put_out(run: Run, log: RunLog | None, output: LogOptions) -> None:
    summary = {"label": label_of(run), **run.summary()}

    def show() -> None:
        if run.laps or not run.aborted:  # a table of nothing measured says nothing
            print_runs("simulation", [summary])

    put_out(summary, output, show)
    if log is not None:
        log.conclude(run)


def _ask(
    choice: FeedforwardChoice,
    robot: Robot,
    motion: Motion,
    axes: tuple[str, ...],
    correction: str,
    services: ServiceOptions,
) -> Feedforward | None:
    if choice is FeedforwardChoice.NONE:
        return None
    with open_learner(services) as learner:
        return learner.query(
            motion.name,
            robot=robot.name,
            kind=choice.value,
            extrapolate=False,
            axes=axes,
            context=context_of(robot, correction),
            version=motion.version,
            **motion.parameters,
        )
