"""'tsd controller' and 'tsd learner': start a service."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tsd_cli.option_groups import with_groups
from tsd_cli.options.robot import RobotOptions
from tsd_cli.options.services import ListenOptions

if TYPE_CHECKING:
    from tsd_server.place import Place


@with_groups
def controller(
    robot: RobotOptions,
    network: ListenOptions,
) -> None:
    """Serve a robot's controller: state and command in, torques out.

    Compiles the robot's QP at the first start (about 20 s) and keeps it. Ends
    on Ctrl-C or SIGTERM.

      tsd controller
      tsd controller --robot my_robot.yaml --listen tcp/127.0.0.1:7450
      tsd controller --listen tls/0.0.0.0:7447 --zenoh-config robot.json5
    """
    from tsd_server.serve import serve_controller

    serve_controller(robot.robot, _prepare(network))


@with_groups
def learner(
    network: ListenOptions,
    database: Annotated[
        Path | None,
        typer.Option(
            "--database",
            metavar="FILE",
            help="SQLite file, made if there is none. Default: in the user's data folder.",
        ),
    ] = None,
) -> None:
    """Serve the database of learned feedforward terms, for every robot.

    Ends on Ctrl-C or SIGTERM; what was recorded stays in the file.

      tsd learner
      tsd learner --database squats.sqlite
    """
    from tsd_server.serve import serve_learner

    serve_learner(database, _prepare(network))


def _prepare(network: ListenOptions) -> Place:
    from tsd_server.log_level import show_log
    from tsd_server.place import Place

    show_log(network.log_level or ("info" if network.verbose else None))
    return Place(network.listen or (), network.zenoh_config, network.expose)
