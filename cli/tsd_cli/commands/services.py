"""'tsd controller' and 'tsd learner': start a service."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsd_casadi.wire.endpoints import CONTROLLER, LEARNER
from tsd_cli.option_groups import with_groups
from tsd_cli.options.robot import RobotOptions


def _listen(default: str) -> typer.models.OptionInfo:
    option: typer.models.OptionInfo = typer.Option(
        "--listen",
        metavar="ENDPOINT",
        help=f"Endpoint to listen on; repeat for more than one. Default: {default}.",
    )
    return option


@with_groups
def controller(
    robot: RobotOptions,
    listen: Annotated[list[str] | None, _listen(CONTROLLER)] = None,
) -> None:
    """Serve a robot's controller: state and command in, torques out.

    Compiles the robot's QP at the first start (about 20 s) and keeps it. Ends
    on Ctrl-C or SIGTERM.

      tsd controller
      tsd controller --robot my_robot.yaml --listen tcp/127.0.0.1:7450
    """
    from tsd_server.serve import serve_controller

    serve_controller(robot.robot, listen or [CONTROLLER])


@with_groups
def learner(
    database: Annotated[
        Path | None,
        typer.Option(
            "--database",
            metavar="FILE",
            help="SQLite file, made if there is none. Default: in the user's data folder.",
        ),
    ] = None,
    listen: Annotated[list[str] | None, _listen(LEARNER)] = None,
) -> None:
    """Serve the database of learned feedforward terms, for every robot.

    Ends on Ctrl-C or SIGTERM; what was recorded stays in the file.

      tsd learner
      tsd learner --database squats.sqlite
    """
    from tsd_server.serve import serve_learner

    serve_learner(database, listen or [LEARNER])
