"""The centre of mass from static poses of the simulated robot."""

from __future__ import annotations

import typer

from tsd_casadi.center_of_mass.fit import fit_correction
from tsd_casadi.center_of_mass.mass_prior import MassPrior
from tsd_casadi.robot.robot import load_robot
from tsd_cli.actions.prepare import make_simulator, open_controller
from tsd_cli.interrupt import interruptible
from tsd_cli.options.calibration import CalibrationOptions
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.robot import SimulatedRobotOptions
from tsd_cli.options.services import ServiceOptions
from tsd_cli.output import check_outputs, put_out
from tsd_clients.console.progress import show_progress
from tsd_clients.console.run_tables import print_accuracy
from tsd_clients.simulator.static_poses import collect, with_noise
from tsd_experiments.beyond.true_center_of_mass.study import assess


@interruptible()
def correct_center_of_mass(
    calibration: CalibrationOptions,
    body: SimulatedRobotOptions,
    services: ServiceOptions,
    output: JsonOptions,
) -> None:
    """Stand in static poses, fit, write the correction and show how good it is.

    Raises:
        TsdError: If it cannot be done as asked.
    """
    check_outputs(output, calibration.out)
    robot = load_robot(body.robot)
    prior = MassPrior(calibration.mass_prior, calibration.center_prior)
    simulator = make_simulator(body, robot)
    poses, noise, seed = calibration.poses, calibration.noise, calibration.seed
    with (
        open_controller(services, robot) as controller,
        show_progress("standing in static poses", poses) as progress,
    ):
        exact = collect(
            simulator,
            controller,
            count=poses,
            inclinometer=calibration.inclinometer,
            seed=seed,
            progress=progress,
        )
    measured = with_noise(exact, noise, seed=seed)
    correction = fit_correction(robot, measured, noise=noise, prior=prior)
    correction.save(calibration.out)
    accuracy = assess(simulator, correction, measured, prior).plain()
    file = str(calibration.out)
    result = {"robot": robot.name, "file": file, "noise_m": noise, **accuracy}
    if len(exact) < poses:
        typer.echo(f"note: {poses - len(exact)} poses left out, not at rest or flat", err=True)
    put_out(result, output, lambda: print_accuracy(file, accuracy))
