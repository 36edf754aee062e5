"""The commands of 'tsd', and what becomes of their errors."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Annotated, NoReturn

import typer

from tsd_casadi.exceptions.base import TsdError
from tsd_casadi.version import __version__
from tsd_cli.commands.calibrate import calibrate
from tsd_cli.commands.experiments import demo, reproduce
from tsd_cli.commands.learn import learn
from tsd_cli.commands.query import forget_entry, list_entries, query
from tsd_cli.commands.robot import list_robots
from tsd_cli.commands.services import controller, learner
from tsd_cli.commands.simulate import simulate
from tsd_cli.help_text import unwrap

FAILED = 1
# set by whoever wants to mend a defect
TRACEBACK = "TSD_TRACEBACK"

HELP = """\
Whole-body control that learns task-specific dynamics.

In two terminals the services:

  tsd controller
  tsd learner

and in a third:

  tsd simulate squat --model-error 0.1
  tsd learn squat --model-error 0.1
  tsd query squat --amplitude 0.03

'tsd demo' does all of it by itself in a few minutes. Amplitudes are metres (half of
peak to peak), frequencies hertz.

Exit codes: 0 done, 1 refused or failed, 2 wrong usage, 3 the robot fell, 130
interrupted.
"""

app = typer.Typer(
    name="tsd",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)
database = typer.Typer(no_args_is_help=True, help="Look at what the learner knows.")
robot = typer.Typer(no_args_is_help=True, help="Look at the robots there are.")
for command in (controller, learner, simulate, learn, calibrate, query, demo, reproduce):
    app.command()(command)
database.command("list")(list_entries)
database.command("forget")(forget_entry)
robot.command("list")(list_robots)
app.add_typer(database, name="database")
app.add_typer(robot, name="robot")


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(f"tsd {__version__}")
        raise typer.Exit


@app.callback(help=unwrap(HELP))
def _tsd(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_show_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
) -> None:
    pass


def run(arguments: Sequence[str] | None = None) -> None:
    """Run the command line; an error is one message on stderr, not a traceback.

    Args:
        arguments: Instead of those of the process.

    Raises:
        SystemExit: Always, with the exit code.
    """
    # pictures are rendered by processes of their own; MuJoCo would look for a window's
    # library with a child in Python, which has its own opinion of Ctrl-C
    os.environ.setdefault("MUJOCO_GL", "disable")
    try:
        app(arguments, prog_name="tsd")
    except (TsdError, OSError) as error:
        _fail(str(error))
    except Exception as error:
        if os.environ.get(TRACEBACK):
            raise
        _fail(
            f"unexpected {type(error).__name__}: {error}\nThis is a defect of tsd: please report "
            f"it, with the traceback that {TRACEBACK}=1 shows"
        )


def _fail(message: str) -> NoReturn:
    typer.echo(f"error: {message}", err=True)
    sys.exit(FAILED)
