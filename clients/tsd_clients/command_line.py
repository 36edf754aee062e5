"""The command 'tsd'.

Exit codes: 0 done; 1 refused or failed, with the reason on stderr; 2 wrong
usage; 3 the simulated robot fell; 130 interrupted.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from tsd_casadi import Squat, compile_controller, load_robot
from tsd_casadi.controller import WholeBodyController
from tsd_casadi.database import default_path
from tsd_casadi.endpoints import CONTROLLER, LEARNER
from tsd_casadi.exceptions import InvalidValue, TsdError
from tsd_casadi.feedforward import Feedforward
from tsd_casadi.motions import Motion
from tsd_casadi.progress import show_progress
from tsd_casadi.robot import Robot
from tsd_clients.learning import learn as learn_motions
from tsd_clients.remote_controller import RemoteController
from tsd_clients.remote_learner import RemoteLearner
from tsd_clients.run import Run
from tsd_clients.simulator import MujocoSimulator
from tsd_clients.tables import console, describe_parameters, print_entries, print_runs

FELL = 3

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    help="""Whole-body control that learns task-specific dynamics.

    Start [bold]tsd controller[/bold] and [bold]tsd learner[/bold] in two terminals, then
    [bold]tsd learn squat[/bold] in a third and [bold]tsd query squat --amplitude 0.05[/bold].
    [bold]tsd demo[/bold] does all of it by itself in a few minutes.

    Amplitudes are metres (half of peak to peak), frequencies hertz. Exit codes: 0 done,
    1 refused or failed, 2 wrong usage, 3 the robot fell, 130 interrupted.""",
)
database_app = typer.Typer(no_args_is_help=True, help="Look at what the learner knows.")
app.add_typer(database_app, name="database")


class FeedforwardChoice(StrEnum):
    """What is fed forward."""

    NONE = "none"
    LEARNED = "learned"
    GENERALISED = "generalised"


class ControllerChoice(StrEnum):
    """Where the controller runs."""

    ZENOH = "zenoh"
    LOCAL = "local"


class RuleChoice(StrEnum):
    """How learning goes on from one iteration to the next."""

    GUARDED = "guarded"
    PLAIN = "plain"


RobotOption = Annotated[
    str, typer.Option("--robot", help="Name of a shipped robot, or path of a robot file (.yaml).")
]
ListenOption = Annotated[
    list[str],
    typer.Option("--listen", help="Endpoint to listen on; repeat for more than one."),
]
ConnectOption = Annotated[
    list[str] | None,
    typer.Option(
        "--connect",
        help="Endpoint of a service; repeat for controller and learner. "
        f"Default: {CONTROLLER} and {LEARNER}.",
    ),
]
MotionArgument = Annotated[str, typer.Argument(help="The motion: squat.")]
AmplitudeOption = Annotated[
    float, typer.Option("--amplitude", help="Half of peak to peak, in metres; 0.03 is 3 cm.")
]
FrequencyOption = Annotated[float, typer.Option("--frequency", help="Laps per second, in hertz.")]
LapsOption = Annotated[
    int, typer.Option("--laps", help="Least number of laps; more are added until steady.")
]
PScaleOption = Annotated[
    float, typer.Option("--p-scale", help="Factor on the learned task's P; D stays as it is.")
]
ModelErrorOption = Annotated[
    float,
    typer.Option(
        "--model-error",
        help="E: the controller's masses and inertias are 1 + E times the simulated "
        "robot's, and the controller is not told; 0.1 is 10 %.",
    ),
]
ControllerOption = Annotated[
    ControllerChoice, typer.Option("--controller", help="The service, or this process.")
]
SeedOption = Annotated[
    int, typer.Option("--seed", min=0, help="Of the starting posture's randomness.")
]
JsonOption = Annotated[
    str | None, typer.Option("--json", help="Write the result as JSON to a file, or - for stdout.")
]


@app.command()
def controller(robot: RobotOption = "hermes_lower", listen: ListenOption = [CONTROLLER]) -> None:  # noqa: B006
    """Serve a robot's controller: state and command in, torques out.

    Compiles the robot's QP at the first start (about 20 s) and keeps it. Ends
    on Ctrl-C or SIGTERM.
    """
    from tsd_server.controller_service import ControllerService

    ControllerService(load_robot(robot), listen).run()


@app.command()
def learner(
    database: Annotated[
        Path | None,
        typer.Option("--database", help="SQLite file. Default: in the user's data folder."),
    ] = None,
    listen: ListenOption = [LEARNER],  # noqa: B006
) -> None:
    """Serve the database of learned feedforward terms, for every robot.

    Ends on Ctrl-C or SIGTERM; what was recorded stays in the file.
    """
    from tsd_server.learner_service import LearnerService

    LearnerService(database or default_path(), listen).run()


@app.command()
def simulate(
    motion: MotionArgument,
    robot: RobotOption = "hermes_lower",
    amplitude: AmplitudeOption = 0.03,
    frequency: FrequencyOption = 0.25,
    laps: LapsOption = 3,
    feedforward: Annotated[
        FeedforwardChoice,
        typer.Option("--feedforward", help="From the learner: the exact entry, or a regression."),
    ] = FeedforwardChoice.NONE,
    p_scale: PScaleOption = 1.0,
    model_error: ModelErrorOption = 0.0,
    controller: ControllerOption = ControllerChoice.ZENOH,
    connect: ConnectOption = None,
    seed: SeedOption = 0,
    json_file: JsonOption = None,
    log: Annotated[
        Path | None, typer.Option("--log", help="Write every tick to this .npz file.")
    ] = None,
) -> None:
    """Simulate one repetition, asking the controller at every tick (1 kHz)."""
    _check_writable(json_file, log)
    loaded = load_robot(robot)
    wanted = make_motion(motion, amplitude, frequency)
    wanted.check(loaded)
    learned = _ask_feedforward(feedforward, loaded, wanted, connect)
    simulator = MujocoSimulator(loaded, model_error)
    with (
        _open_controller(controller, loaded, connect) as opened,
        show_progress(f"{motion} {amplitude:g} m", 1.0) as progress,
    ):
        run = simulator.run(
            opened,
            wanted,
            laps=laps,
            feedforward=learned,
            p_scale=p_scale,
            seed=seed,
            transport=controller.value,
            progress=progress,
        )
    if log is not None:
        run.save_log(log)
    summary = {"label": _label(run), **run.summary()}
    _put_out(summary, json_file, lambda: print_runs("simulation", [summary]))
    if run.fell:
        raise typer.Exit(FELL)


@app.command()
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
        typer.Option("--rule", help="guarded: never go on from what proved worse; plain: sum."),
    ] = RuleChoice.GUARDED,
    robot: RobotOption = "hermes_lower",
    amplitude: AmplitudeOption = 0.03,
    frequency: FrequencyOption = 0.25,
    laps: LapsOption = 3,
    p_scale: PScaleOption = 1.0,
    model_error: ModelErrorOption = 0.0,
    controller: ControllerOption = ControllerChoice.ZENOH,
    connect: ConnectOption = None,
    seed: SeedOption = 0,
    json_file: JsonOption = None,
) -> None:
    """Learn a motion's feedforward by repeating it; continues an existing entry."""
    _check_writable(json_file)
    loaded = load_robot(robot)
    wanted = make_motion(motion, amplitude, frequency)
    wanted.check(loaded)
    if iterations < 1:
        raise InvalidValue("iterations", iterations, "at least 1")
    simulator = MujocoSimulator(loaded, model_error)
    summaries: list[dict[str, Any]] = []

    def keep(run: Run, notes: list[str]) -> None:
        summaries.append({"label": _label(run), **run.summary(), "notes": notes})
        for note in notes:
            typer.echo(f"note: {note}", err=True)

    with (
        RemoteLearner(connect or [LEARNER]) as remote,
        _open_controller(controller, loaded, connect) as opened,
        show_progress(f"learning {motion} {amplitude:g} m", iterations + 1.0) as progress,
    ):

        def progress_of(_: Motion, index: int) -> Any:
            return lambda done, total: progress(index + done / total, iterations + 1.0)

        learn_motions(
            simulator,
            opened,
            [wanted],
            remote,
            iterations=iterations,
            restart=restart,
            rule=rule.value,
            laps=laps,
            p_scale=p_scale,
            seed=seed,
            transport=controller.value,
            progress=progress_of,
            on_run=keep,
        )
    result = {"robot": loaded.name, "task": motion, "runs": summaries}
    _put_out(result, json_file, lambda: print_runs(f"learning {motion}", summaries))


@app.command()
def query(
    motion: MotionArgument,
    amplitude: Annotated[
        float, typer.Option("--amplitude", help="Half of peak to peak, in metres.")
    ],
    frequency: FrequencyOption = 0.25,
    robot: RobotOption = "hermes_lower",
    kind: Annotated[
        str | None,
        typer.Option("--kind", help="learned or generalised; default: learned where it exists."),
    ] = None,
    extrapolate: Annotated[
        bool, typer.Option("--extrapolate", help="Answer outside the learned range too.")
    ] = False,
    connect: ConnectOption = None,
    json_file: JsonOption = None,
) -> None:
    """Ask the learner what to feed forward."""
    _check_writable(json_file)
    loaded = load_robot(robot)
    wanted = make_motion(motion, amplitude, frequency)
    wanted.check(loaded)
    with RemoteLearner(connect or [LEARNER]) as remote:
        message = remote.query_message(
            motion, robot=loaded.name, kind=kind, extrapolate=extrapolate, **wanted.parameters
        )
    plain = json.loads(message.encode())
    _put_out(plain, json_file, lambda: _print_feedforward(message.feedforward()))


@database_app.command("list")
def list_entries(connect: ConnectOption = None, json_file: JsonOption = None) -> None:
    """List what was learned."""
    _check_writable(json_file)
    with RemoteLearner(connect or [LEARNER]) as remote:
        reply = remote.database()
    _put_out(reply.model_dump(mode="json"), json_file, lambda: print_entries(reply))


@database_app.command("forget")
def forget_entry(
    entry: Annotated[int, typer.Argument(help="Number of the entry, from 'tsd database list'.")],
    connect: ConnectOption = None,
) -> None:
    """Remove one entry with all its iterations."""
    with RemoteLearner(connect or [LEARNER]) as remote:
        reply = remote.forget(entry)
    if reply.forgotten is not None:
        forgotten = reply.forgotten
        typer.echo(
            f"forgot entry {forgotten.entry}: {forgotten.task} of {forgotten.robot}, "
            f"{describe_parameters(forgotten)}"
        )


@app.command()
def demo(
    robot: RobotOption = "hermes_lower",
    out: Annotated[
        Path, typer.Option("--out", help="Folder for summary, logs and figures.")
    ] = Path("results/demo"),
) -> None:
    """Show everything: services, learning, lower gains, generalisation (about 3 minutes)."""
    from tsd_clients.demo import run_demo

    run_demo(load_robot(robot), out)


def make_motion(name: str, amplitude: float, frequency: float) -> Motion:
    """A motion by its name.

    Args:
        name: Its name.
        amplitude: Half of peak to peak [m].
        frequency: Laps per second [Hz].

    Raises:
        InvalidValue: If there is none of that name.
    """
    if name != Squat.name:
        raise InvalidValue("motion", repr(name), f"'{Squat.name}', the only one there is")
    return Squat(amplitude, frequency)


@contextmanager
def _open_controller(
    choice: ControllerChoice, robot: Robot, connect: list[str] | None
) -> Iterator[WholeBodyController]:
    if choice is ControllerChoice.LOCAL:
        yield compile_controller(robot)
        return
    with RemoteController(robot.name, connect or [CONTROLLER]) as remote:
        yield remote


def _ask_feedforward(
    choice: FeedforwardChoice, robot: Robot, motion: Motion, connect: list[str] | None
) -> Feedforward | None:
    if choice is FeedforwardChoice.NONE:
        return None
    with RemoteLearner(connect or [LEARNER]) as remote:
        return remote.query(
            motion.name, robot=robot.name, kind=choice.value, extrapolate=False, **motion.parameters
        )


def _label(run: Run) -> str:
    parts = [f"{run.motion.name} {100 * run.motion.parameters['amplitude']:g} cm"]
    kind = run.feedforward.kind
    parts.append(f"{kind}, iteration {run.feedforward.iteration}" if kind != "none" else "none")
    if run.settings["p_scale"] != 1.0:
        parts.append(f"P x {run.settings['p_scale']:g}")
    return ", ".join(parts)


def _print_feedforward(feedforward: Feedforward) -> None:
    import numpy as np

    parameters = " ".join(f"{name}={value:g}" for name, value in feedforward.parameters.items())
    console.print(f"{feedforward.kind} feedforward for {parameters}, axes {feedforward.axes}")
    source = "entries {entries}, iteration {iteration}".format(**feedforward.provenance)
    console.print(f"from {source}; the whole answer: --json -")
    phase = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    mean, std = feedforward.mean(phase), feedforward.std(phase)
    for axis, name in enumerate(feedforward.axes):
        for p, m, s in zip(phase, mean[axis], std[axis], strict=True):
            console.print(f"  {name}  phase {p:5.3f} rad  {m:9.5f} ± {s:.5f} m/s²")


def _put_out(result: dict[str, Any], json_file: str | None, show: Any) -> None:
    if json_file == "-":
        typer.echo(json.dumps(result, indent=2))
        return
    show()
    if json_file is not None:
        Path(json_file).write_text(json.dumps(result, indent=2))


def _check_writable(*targets: str | Path | None) -> None:
    """Refuse a file that cannot be written before the work, not after it."""
    for target in targets:
        if target is None or target == "-":
            continue
        try:
            with Path(target).open("a"):
                pass
        except OSError as error:
            raise InvalidValue(
                "output file", f"'{target}' ({error.strerror})", "a writable path"
            ) from error


def main() -> None:
    """Run the command line; errors are one message on stderr, not a traceback."""
    try:
        app()
    except TsdError as error:
        typer.echo(f"error: {error}", err=True)
        sys.exit(1)


if __name__ == "__main__":
    main()
