"""Options that commands share, and what they stand for."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from tsd_casadi.center_of_mass.correction import CenterOfMassCorrection
from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.controller.controller import WholeBodyController
from tsd_casadi.exceptions import InvalidValue, SimulationError
from tsd_casadi.motions.motion import Motion
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.center_of_mass_shift import CenterOfMassShift
from tsd_casadi.repetition.compensator import Compensator
from tsd_casadi.robot.robot import Robot
from tsd_casadi.wire.endpoints import CONTROLLER, LEARNER
from tsd_clients.remote.remote_controller import RemoteController
from tsd_clients.simulator.effects import EFFECTS
from tsd_clients.simulator.model_error import ModelError
from tsd_clients.simulator.simulator import MujocoSimulator

ROBOT = "hermes_lower"


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
    STABLE = "stable"


class FirstChoice(StrEnum):
    """What a motion of which nothing is known starts with."""

    NONE = "none"
    GENERALISED = "generalised"


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
PScaleOption = Annotated[float, typer.Option("--p-scale", help="Factor on the learned task's P.")]
DScaleOption = Annotated[float, typer.Option("--d-scale", help="Factor on the learned task's D.")]
HeightOption = Annotated[
    float, typer.Option("--height", help="Middle of the motion above home, in metres.")
]
ModelErrorOption = Annotated[
    float,
    typer.Option(
        "--model-error",
        help="E: the controller's masses and inertias are 1 + E times the simulated "
        "robot's, and the controller is not told; 0.1 is 10 %.",
    ),
]
LinkErrorOption = Annotated[
    float,
    typer.Option(
        "--link-error", help="A further error with random sign on each link; 0.1 is 10 %."
    ),
]
LinkSeedOption = Annotated[int, typer.Option("--link-seed", min=0, help="Of those signs.")]
HardwareOption = Annotated[
    str,
    typer.Option(
        "--hardware",
        help="What the simulated robot has beyond rigid bodies: all, or a list such as "
        f"friction,lag out of {', '.join(EFFECTS)}. Numbers: section hardware of the robot file.",
    ),
]
ComCorrectionOption = Annotated[
    Path | None,
    typer.Option("--com-correction", help="Corrected centre of mass, from 'tsd calibrate'."),
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


def make_simulator(
    robot: Robot, model_error: float, link_error: float, link_seed: int, hardware: str
) -> MujocoSimulator:
    """The simulated robot of the options.

    Args:
        robot: The robot as the controller knows it.
        model_error: E of every link.
        link_error: A further error with random sign on each link.
        link_seed: Of the signs.
        hardware: Names of hardware effects, separated by commas.

    Raises:
        InvalidValue: If an option is out of range.
    """
    effects = [name.strip() for name in hardware.split(",") if name.strip()]
    return MujocoSimulator(robot, ModelError(model_error, link_error, link_seed), effects)


def make_motion(name: str, amplitude: float, frequency: float, height: float) -> Motion:
    """A motion by its name.

    Args:
        name: Its name.
        amplitude: Half of peak to peak [m].
        frequency: Laps per second [Hz].
        height: Middle of the motion above home [m].

    Raises:
        InvalidValue: If there is none of that name.
    """
    if name != Squat.name:
        raise InvalidValue("motion", repr(name), f"'{Squat.name}', the only one there is")
    return Squat(amplitude, frequency, height)


def read_compensators(robot: Robot, file: Path | None) -> list[Compensator]:
    """The compensators of the options.

    Args:
        robot: The robot.
        file: A corrected centre of mass, or none.

    Raises:
        TsdError: If the file is not one of this robot.
    """
    if file is None:
        return []
    return [CenterOfMassShift(CenterOfMassCorrection.load(robot, file))]


@contextmanager
def open_controller(
    choice: ControllerChoice, robot: Robot, connect: list[str] | None
) -> Iterator[WholeBodyController]:
    """The controller of the options, closed at the end.

    Args:
        choice: Where it runs.
        robot: The robot.
        connect: Endpoints of the service.

    Raises:
        ServiceUnreachable: If no service answers.
        SimulationError: If the service has other files of the robot.
    """
    if choice is ControllerChoice.LOCAL:
        yield compile_controller(robot)
        return
    with RemoteController(robot.name, connect or [CONTROLLER]) as remote:
        if remote.model != robot.fingerprint:
            raise SimulationError(
                f"the controller service was started with other files of {robot.name} (model "
                f"{remote.model}) than {robot.path} (model {robot.fingerprint}); start it again "
                "with the same --robot"
            )
        yield remote
