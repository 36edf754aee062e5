"""What options stand for: motion, simulated robot, controller, learner."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from tsd_casadi.center_of_mass.correction import CenterOfMassCorrection
from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.controller.controller import Controller, WholeBodyController
from tsd_casadi.exceptions import InvalidValue, SimulationError
from tsd_casadi.exceptions.did_you_mean import did_you_mean
from tsd_casadi.motions.motion import Motion
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.center_of_mass_shift import CenterOfMassShift
from tsd_casadi.repetition.compensator import Compensator
from tsd_casadi.repetition.gains import Gains
from tsd_casadi.robot.robot import Robot
from tsd_casadi.wire.endpoints import CONTROLLER, LEARNER
from tsd_cli.options.motion import AskedMotion, RepetitionOptions
from tsd_cli.options.robot import SimulatedRobotOptions
from tsd_cli.options.services import ConnectOptions, ControllerChoice, ServiceOptions
from tsd_clients.console.progress import show_activity
from tsd_clients.remote.remote_controller import RemoteController
from tsd_clients.remote.remote_learner import RemoteLearner
from tsd_clients.simulator.model_error import ModelError
from tsd_clients.simulator.simulator import MujocoSimulator

MOTIONS = {Squat.name: Squat}


def make_motion(name: str, amplitude: float, frequency: float, height: float) -> Motion:
    """Make a motion by its name.

    Args:
        amplitude: Half of peak to peak [m].
        frequency: Laps per second [Hz].
        height: Middle of the motion above home [m].

    Raises:
        InvalidValue: If there is none of that name.
    """
    if name not in MOTIONS:
        known = ", ".join(f"'{each}'" for each in MOTIONS)
        raise InvalidValue("motion", f"'{name}'", f"one of {known}{did_you_mean(name, MOTIONS)}")
    return MOTIONS[name](amplitude, frequency, height)


def asked_motion(options: AskedMotion, robot: Robot) -> Motion:
    """Make the motion of the options.

    Raises:
        InvalidValue: If there is none of that name, or the robot cannot do it.
    """
    motion = make_motion(options.motion, options.amplitude, options.frequency, options.height)
    motion.check(robot)
    return motion


def make_simulator(options: SimulatedRobotOptions, robot: Robot) -> MujocoSimulator:
    """Make the simulated robot of the options.

    Raises:
        InvalidValue: If an option is out of range.
    """
    effects = [name.strip() for name in options.hardware.split(",") if name.strip()]
    error = ModelError(options.model_error, options.link_error, options.link_seed)
    return MujocoSimulator(robot, error, effects)


def chosen_gains(options: RepetitionOptions) -> Gains:
    """Read the factors on the gains.

    Raises:
        InvalidValue: If one is no factor.
    """
    return Gains(options.p_scale, options.d_scale)


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
def open_controller(options: ServiceOptions, robot: Robot) -> Iterator[WholeBodyController]:
    """Open the controller of the options, and close it at the end.

    Raises:
        ServiceUnreachable: If no service answers.
        SimulationError: If the service has other files of the robot.
    """
    if options.controller is ControllerChoice.LOCAL:
        yield compile_with_activity(robot)
        return
    with RemoteController(robot.name, options.connect or [CONTROLLER]) as remote:
        if remote.model != robot.fingerprint:
            raise SimulationError(
                f"the controller service was started with other files of {robot.name} (model "
                f"{remote.model}) than {robot.path} (model {robot.fingerprint}); start it again "
                "with the same --robot"
            )
        yield remote


def open_learner(options: ConnectOptions) -> RemoteLearner:
    """Connect to the learner of the options.

    Raises:
        ServiceUnreachable: If no service answers.
    """
    return RemoteLearner(options.connect or [LEARNER])
