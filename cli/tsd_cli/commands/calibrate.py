"""'tsd calibrate': correct the centre of mass."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsd_casadi.center_of_mass.fit import NOISE, MassPrior, fit_correction
from tsd_casadi.robot.robot import load_robot
from tsd_cli.commands.options import (
    ROBOT,
    ConnectOption,
    ControllerChoice,
    ControllerOption,
    HardwareOption,
    JsonOption,
    LinkErrorOption,
    LinkSeedOption,
    ModelErrorOption,
    RobotOption,
    make_simulator,
    open_controller,
)
from tsd_cli.commands.output import check_writable, put_out
from tsd_clients.console.progress import show_progress
from tsd_clients.console.tables import print_accuracy
from tsd_clients.simulator.static_poses import collect, with_noise
from tsd_experiments.beyond.center_of_mass_study import assess


def calibrate(
    out: Annotated[Path, typer.Option("--out", help="File for the correction (JSON).")],
    robot: RobotOption = ROBOT,
    poses: Annotated[
        int, typer.Option("--poses", help="Number of static poses; each takes about 2.5 s.")
    ] = 30,
    noise: Annotated[
        float,
        typer.Option(
            "--noise",
            min=1e-6,
            help="Standard deviation of a pose's averaged centre of pressure, in metres; added to "
            "the simulated one and known to the fit.",
        ),
    ] = NOISE,
    inclinometer: Annotated[
        float | None,
        typer.Option(
            "--inclinometer",
            min=0.0,
            help="Standard deviation of an inclinometer on the base, in radians, such as 1e-4; "
            "without one the joint angles tell the base's lean, if hardware says so.",
        ),
    ] = None,
    mass_prior: Annotated[
        float,
        typer.Option("--mass-prior", help="How far each link's mass may be off; 0.1 is 10 %."),
    ] = MassPrior.mass,
    center_prior: Annotated[
        float,
        typer.Option(
            "--center-prior", help="How far each link's centre of mass may be off, in metres."
        ),
    ] = MassPrior.center,
    model_error: ModelErrorOption = 0.0,
    link_error: LinkErrorOption = 0.0,
    link_seed: LinkSeedOption = 0,
    hardware: HardwareOption = "",
    controller: ControllerOption = ControllerChoice.ZENOH,
    connect: ConnectOption = None,
    seed: Annotated[
        int, typer.Option("--seed", min=0, help="Of poses, start and sensor noise.")
    ] = 0,
    json_file: JsonOption = None,
) -> None:
    """Correct the centre of mass from centres of pressure of static poses.

    A controller with wrong masses regulates the wrong point: learning takes away
    the error it sees and leaves that of the true centre of mass. Standing still,
    the centre of mass is straight above the centre of pressure; poses that lean
    differently give its height as well. Use the file with
    [bold]tsd learn squat --com-correction FILE[/bold], the same model options
    for the simulated robot given.
    """
    check_writable(out, json_file)
    loaded = load_robot(robot)
    prior = MassPrior(mass_prior, center_prior)
    simulator = make_simulator(loaded, model_error, link_error, link_seed, hardware)
    with (
        open_controller(controller, loaded, connect) as opened,
        show_progress("standing in static poses", poses) as progress,
    ):
        exact = collect(
            simulator,
            opened,
            count=poses,
            inclinometer=inclinometer,
            seed=seed,
            progress=progress,
        )
    measured = with_noise(exact, noise, seed=seed)
    correction = fit_correction(loaded, measured, noise=noise, prior=prior)
    correction.save(out)
    accuracy = assess(simulator, correction, measured, prior)
    result = {"robot": loaded.name, "file": str(out), "noise_m": noise, **accuracy.plain()}
    if len(exact) < poses:
        typer.echo(f"note: {poses - len(exact)} poses left out, not at rest or flat", err=True)
    put_out(result, json_file, lambda: print_accuracy(str(out), accuracy.plain()))
