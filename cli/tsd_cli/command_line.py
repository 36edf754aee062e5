"""The commands of 'tsd', and what becomes of their errors."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from typing import Annotated, Any, NoReturn

import typer

from tsd_casadi.exceptions.base import TsdError
from tsd_casadi.version import __version__
from tsd_cli.commands.calibrate import calibrate
from tsd_cli.commands.database import export_entries, import_entries, verify_database
from tsd_cli.commands.experiments import demo, reproduce
from tsd_cli.commands.explain import explain
from tsd_cli.commands.learn import learn
from tsd_cli.commands.log import convert_log, cut_log, plot_log, recover_log, show_log
from tsd_cli.commands.log_video import film_log
from tsd_cli.commands.motion import list_motions, show_motion
from tsd_cli.commands.query import forget_entry, list_entries, query
from tsd_cli.commands.robot import check_robot, list_robots, new_robot
from tsd_cli.commands.services import controller, learner
from tsd_cli.commands.simulate import simulate
from tsd_cli.commands.status import status
from tsd_cli.commands.view import view
from tsd_cli.help_text import unwrap
from tsd_cli.motion_parameters import named_motion, with_parameters

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

'tsd status' says which services run and how they are. 'tsd demo' does all of it by
itself in a few minutes, 'tsd motion list' names what else a robot can be asked to do.
Amplitudes are metres (half of peak to peak), frequencies hertz.

Exit codes: 0 done, 1 refused or failed, 2 wrong usage, 3 the robot fell, 4 a run
that began was ended by an error and what there is of it is kept, 130 interrupted.
"""

COMMANDS = (
    controller,
    learner,
    status,
    simulate,
    learn,
    view,
    explain,
    calibrate,
    query,
    demo,
    reproduce,
)
# those that take a motion, and whether they move the robot
ABOUT_A_MOTION = {simulate.__name__: True, learn.__name__: True, query.__name__: False}
GROUPS = {
    "database": (
        "Look at what the learner knows, and carry it from machine to machine.",
        {
            "list": list_entries,
            "forget": forget_entry,
            "export": export_entries,
            "import": import_entries,
            "verify": verify_database,
        },
    ),
    "log": (
        "Look at what a run wrote with --log, and carry it to other tools.",
        {
            "show": show_log,
            "plot": plot_log,
            "video": film_log,
            "cut": cut_log,
            "convert": convert_log,
            "recover": recover_log,
        },
    ),
    "motion": ("Look at the motions there are.", {"list": list_motions, "show": show_motion}),
    "robot": (
        "Look at robots, and bring your own.",
        {"list": list_robots, "new": new_robot, "check": check_robot},
    ),
}


def app_for(arguments: Sequence[str]) -> typer.Typer:
    """Make the commands, with options for the parameters of the motion that is named.

    Args:
        arguments: Of the process.

    Raises:
        TsdError: If there is no such motion, or its file cannot be used.
    """
    made = _make_app(COMMANDS)
    name = next(iter(arguments), "")
    if name not in ABOUT_A_MOTION:
        return made
    click_app: Any = typer.main.get_command(made)
    motion = named_motion(arguments[1:], click_app.commands[name])
    if motion is None:
        return made
    from tsd_casadi.motions.catalogue import find_motion

    declaration = find_motion(motion).declaration()
    return _make_app(
        tuple(
            with_parameters(each, declaration, moves=ABOUT_A_MOTION[name])
            if each.__name__ == name
            else each
            for each in COMMANDS
        )
    )


def _make_app(commands: Sequence[Callable[..., None]]) -> typer.Typer:
    app = typer.Typer(
        name="tsd",
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode="rich",
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback(help=unwrap(HELP))(_tsd)
    for command in commands:
        app.command()(command)
    for name, (text, parts) in GROUPS.items():
        group = typer.Typer(no_args_is_help=True, help=text)
        for part, command in parts.items():
            group.command(part)(command)
        app.add_typer(group, name=name)
    return app


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(f"tsd {__version__}")
        raise typer.Exit


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
    given = sys.argv[1:] if arguments is None else arguments
    try:
        app_for(given)(given, prog_name="tsd")
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
