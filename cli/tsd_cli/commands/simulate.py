"""'tsd simulate': one repetition."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.motion import Motion
from tsd_casadi.repetition.feedforward_gate import FeedforwardGate
from tsd_casadi.repetition.gains import Gains
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
    FeedforwardChoice,
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
    SeedOption,
    make_motion,
    make_simulator,
    open_controller,
    read_compensators,
)
from tsd_cli.commands.output import check_writable, label_of, put_out
from tsd_clients.console.progress import show_progress
from tsd_clients.console.tables import print_runs
from tsd_clients.logs.log_file import save_log
from tsd_clients.remote.remote_learner import RemoteLearner

FELL = 3


def simulate(
    motion: MotionArgument,
    robot: RobotOption = ROBOT,
    amplitude: AmplitudeOption = 0.03,
    frequency: FrequencyOption = 0.25,
    laps: LapsOption = 3,
    feedforward: Annotated[
        FeedforwardChoice,
        typer.Option("--feedforward", help="From the learner: the exact entry, or a regression."),
    ] = FeedforwardChoice.NONE,
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
    log: Annotated[
        Path | None, typer.Option("--log", help="Write every tick to this .npz file.")
    ] = None,
) -> None:
    """Simulate one repetition, asking the controller at every tick (1 kHz)."""
    check_writable(json_file, log)
    loaded = load_robot(robot)
    wanted = make_motion(motion, amplitude, frequency, height)
    wanted.check(loaded)
    compensators = read_compensators(loaded, com_correction)
    gate = FeedforwardGate()
    if feedforward is FeedforwardChoice.GENERALISED:
        compensators.append(gate)
    learned = _ask_feedforward(feedforward, loaded, wanted, connect)
    simulator = make_simulator(loaded, model_error, link_error, link_seed, hardware)
    with (
        open_controller(controller, loaded, connect) as opened,
        show_progress(f"{motion} {amplitude:g} m", 1.0) as progress,
    ):
        run = simulator.run(
            opened,
            wanted,
            laps=laps,
            feedforward=learned,
            gains=Gains(p_scale, d_scale),
            compensators=compensators,
            seed=seed,
            transport=controller.value,
            progress=progress,
        )
    if log is not None:
        save_log(run, log)
    if gate.dropped_at is not None:
        typer.echo(
            f"note: generalised feedforward dropped at {gate.dropped_at:.2f} s: tracking was "
            "worse with it than without",
            err=True,
        )
    summary = {"label": label_of(run), **run.summary()}
    put_out(summary, json_file, lambda: print_runs("simulation", [summary]))
    if run.fell:
        raise typer.Exit(FELL)


def _ask_feedforward(
    choice: FeedforwardChoice, robot: Robot, motion: Motion, connect: list[str] | None
) -> Feedforward | None:
    if choice is FeedforwardChoice.NONE:
        return None
    with RemoteLearner(connect or [LEARNER]) as remote:
        return remote.query(
            motion.name, robot=robot.name, kind=choice.value, extrapolate=False, **motion.parameters
        )
