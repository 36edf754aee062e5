"""'tsd motion': what a robot can be asked to do."""

from __future__ import annotations

from typing import Annotated

import typer

from tsd_cli.option_groups import with_groups
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.robot import RobotOptions


@with_groups
def list_motions(output: JsonOptions) -> None:
    """List the motions that come with the project, with their parameters.

    A motion of your own is a class in a file: docs/own-motion.md.

      tsd motion list
      tsd motion list --json -
    """
    from tsd_cli.actions.motions import show_motions

    show_motions(output)


@with_groups
def show_motion(
    motion: Annotated[
        str,
        typer.Argument(
            metavar="MOTION", help="Name of a motion, my_motion.py:Bounce, or wave.csv."
        ),
    ],
    robot: RobotOptions,
    output: JsonOptions,
) -> None:
    """Show what a motion moves, and the range of each parameter on a robot.

    tsd motion show sway
    tsd motion show my_motion.py:Bounce --robot my_robot.yaml
    """
    from tsd_cli.actions.motions import show_one

    show_one(motion, robot, output)
