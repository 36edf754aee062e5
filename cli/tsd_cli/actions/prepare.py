"""What options stand for: motion, simulated robot, controller."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import typer

from tsd_casadi.center_of_mass.correction import CenterOfMassCorrection
from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.controller.controller import Controller, WholeBodyController
from tsd_casadi.exceptions import InvalidValue, SimulationError
from tsd_casadi.exceptions.did_you_mean import did_you_mean
from tsd_casadi.motions.catalogue import find_motion
from tsd_casadi.motions.motion import Motion
from tsd_casadi.motions.parameter import Parameter
from tsd_casadi.motions.ranges import check_motion, usual_of
from tsd_casadi.repetition.center_of_mass_shift import CenterOfMassShift
from tsd_casadi.repetition.compensator import Compensator
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.repetition.pace import Pace
from tsd_casadi.repetition.patience import PATIENCE, check_patience
from tsd_casadi.repetition.repeat import usual_axes
from tsd_casadi.robot.robot import Robot
from tsd_casadi.wire.endpoints import CONTROLLER
from tsd_cli.options.motion import MotionOptions, RepetitionOptions
from tsd_cli.options.pace import PaceOptions
from tsd_cli.options.robot import SimulatedRobotOptions
from tsd_cli.options.services import ControllerChoice, ServiceOptions
from tsd_clients.console.progress import show_activity
from tsd_clients.remote.lock_step import NOTICEABLE
from tsd_clients.remote.remote_controller import RemoteController
from tsd_clients.simulator.model_error import ModelError
from tsd_clients.simulator.simulator import MujocoSimulator


def asked_motion(options: MotionOptions, robot: Robot) -> Motion:
    """Make the motion of the options; what was not said is as usual for the robot.

    Raises:
        InvalidValue: If there is none of that name, or the robot cannot do it.
    """
    kind = find_motion(options.motion)
    declaration = kind.declaration()
    parameters = dict(options.parameters)
    for item in declaration.parameters:
        if item.name in parameters:
            continue
        value = usual_of(robot, kind, item)
        if value is not None:
            parameters[item.name] = value
            _tell_if_unusual(robot, item, value)
    motion = kind(**declaration.complete(parameters))
    check_motion(robot, motion)
    return motion


def _tell_if_unusual(robot: Robot, item: Parameter, value: float) -> None:
    """Say that a robot's range does not hold what is usual."""
    usual = item.usual if item.default is None else item.default
    if usual is not None and value != usual:
        end = "largest" if value < usual else "smallest"
        text = f"{item.name} {value:g} {item.unit}".rstrip()
        typer.echo(f"note: {text}, the {end} for {robot.name}", err=True)


def chosen_axes(options: MotionOptions, robot: Robot, motion: Motion) -> tuple[str, ...]:
    """Read which axes are learned.

    Raises:
        InvalidValue: If one is none of the robot's, or named twice.
    """
    if options.axes is None:
        return usual_axes(robot, motion)
    axes = tuple(name.strip() for name in options.axes.split(","))
    there = [f"{part.name}.{axis}" for part in robot.description.tasks for axis in part.axes]
    for axis in axes:
        if axis not in there:
            raise InvalidValue(
                "--axes",
                f"'{axis}'",
                f"some of {', '.join(there)}{did_you_mean(axis, there)}",
            )
        if axes.count(axis) > 1:
            raise InvalidValue("--axes", f"'{axis}' twice", "each axis once")
    return axes


def make_simulator(
    options: SimulatedRobotOptions, robot: Robot, period: float = 1e-3
) -> MujocoSimulator:
    """Make the simulated robot of the options.

    Args:
        period: Control period [s].

    Raises:
        InvalidValue: If an option is out of range.
    """
    effects = [name.strip() for name in options.hardware.split(",") if name.strip()]
    error = ModelError(options.model_error, options.link_error, options.link_seed)
    return MujocoSimulator(robot, error, effects, period=period)


def chosen_gains(options: RepetitionOptions) -> Gains:
    """Read the factors on the gains.

    Raises:
        InvalidValue: If one is no factor.
    """
    return Gains(options.p_scale, options.d_scale)


def chosen_pace(options: PaceOptions) -> Pace | None:
    """Read how fast it goes by the clock; None if simulated time waits for answers.

    Raises:
        InvalidValue: If pace or patience is out of range.
    """
    check_patience(options.patience)
    return None if options.pace is None else Pace(options.pace, options.patience)


def chosen_compensators(options: RepetitionOptions, robot: Robot) -> list[Compensator]:
    """Read the compensators of the options.

    Raises:
        TsdError: If a file is not one of this robot.
    """
    if options.com_correction is None:
        return []
    return [CenterOfMassShift(CenterOfMassCorrection.load(robot, options.com_correction))]


def compile_with_activity(robot: Robot) -> Controller:
    """Load a robot's controller; if it has to be compiled, show that something is under way."""
    with ExitStack() as until_done:

        def announce() -> None:
            text = f"compiling the controller of {robot.name} (once, about 20 s)"
            until_done.enter_context(show_activity(text))

        return compile_controller(robot, on_compile=announce)


@contextmanager
def open_controller(
    options: ServiceOptions, robot: Robot, patience: float = PATIENCE
) -> Iterator[WholeBodyController]:
    """Open the controller of the options, and close it at the end.

    Args:
        patience: How long it may be silent [s].

    Raises:
        ServiceUnreachable: If no service answers.
        SimulationError: If the service has other files of the robot.
    """
    if options.controller is ControllerChoice.LOCAL:
        yield compile_with_activity(robot)
        return
    with RemoteController(
        robot.name, options.endpoints(CONTROLLER), patience, zenoh_file=options.zenoh_file()
    ) as remote:
        if remote.model != robot.fingerprint:
            raise SimulationError(
                f"the controller service was started with other files of {robot.name} (model "
                f"{remote.model}) than {robot.path} (model {robot.fingerprint}); start it again "
                "with the same --robot"
            )
        try:
            yield remote
        finally:
            _tell_what_was_waited_for(remote)


def _tell_what_was_waited_for(remote: RemoteController) -> None:
    """Say what simulated time stood still for, if a user would have noticed."""
    waited = {cause.words: seconds for cause, seconds in remote.waited.items() if seconds}
    if sum(waited.values()) > NOTICEABLE:
        parts = ", ".join(f"{words} {seconds:.1f} s" for words, seconds in waited.items())
        typer.echo(f"note: waited for the controller: {parts}", err=True)
