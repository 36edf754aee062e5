"""'tsd robot': the robots there are, and one of your own."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsd_cli.option_groups import with_groups
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.proposal import ProposalOptions


@with_groups
def list_robots(output: JsonOptions) -> None:
    """List the robots that come with the project.

    Each name is one for --robot; a robot of your own is the path of its file.

      tsd robot list
      tsd robot list --json -
    """
    from tsd_cli.actions.robots import show_robots

    show_robots(output)


@with_groups
def check_robot(
    robot_file: Annotated[
        str,
        typer.Argument(
            metavar="FILE", help="A robot file (.yaml), or the name of a shipped robot."
        ),
    ],
    output: JsonOptions,
    out: Annotated[
        Path, typer.Option("--out", metavar="FOLDER", help="Folder for the pictures.")
    ] = Path("results/check"),
    pictures: Annotated[
        bool, typer.Option("--pictures/--no-pictures", help="Draw home and each motion's extremes.")
    ] = True,
) -> None:
    """Look for what is wrong with a robot before it moves.

    Goes to the ends of each motion's range: how near to their limits the joints come where
    the model is 10 % wrong, how much of torque and friction is needed, where the weight is
    on the soles. Names limits that look like placeholders and links that cannot be, with
    the lines to write into the robot file. Exits with 1 for what cannot work.

      tsd robot check my_robot.yaml
      tsd robot check my_robot.yaml --no-pictures --json -
    """
    from tsd_cli.actions.examination import check_robot_file

    check_robot_file(robot_file, out if pictures else None, output)


@with_groups
def new_robot(
    proposal: ProposalOptions,
    output: JsonOptions,
    file: Annotated[
        Path | None, typer.Argument(metavar="FILE", help="A URDF, xacro or MJCF.")
    ] = None,
) -> None:
    """Write a robot file for a description of links and joints.

    Finds the soles under both feet, a crouch to work from and how far each motion may go;
    locks what is named, and what cannot be controlled. Says what it found and assumed. The
    file loads as it is, its comments say what to look at.

      tsd robot new my_robot.urdf --feet left_foot,right_foot --lock '.*_finger_.*'
      tsd robot new --package g1 --feet left_ankle_roll_link,right_ankle_roll_link
    """
    from tsd_cli.actions.new_robot import write_new_robot

    write_new_robot(file, proposal, output)
