"""'tsd controller' and 'tsd learner': start a service."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsd_casadi.database.database import default_path
from tsd_casadi.robot.robot import load_robot
from tsd_casadi.wire.endpoints import CONTROLLER, LEARNER
from tsd_cli.commands.options import (
    ROBOT,
    ListenOption,
    RobotOption,
)


def controller(robot: RobotOption = ROBOT, listen: ListenOption = [CONTROLLER]) -> None:  # noqa: B006
    """Serve a robot's controller: state and command in, torques out.

    Compiles the robot's QP at the first start (about 20 s) and keeps it. Ends
    on Ctrl-C or SIGTERM.
    """
    from tsd_server.controller_service import ControllerService

    ControllerService(load_robot(robot), listen).run()


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
