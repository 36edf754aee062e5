"""The command 'tsd'.

Exit codes: 0 done; 1 refused or failed, with the reason on stderr; 2 wrong
usage; 3 the simulated robot fell; 130 interrupted.
"""

from __future__ import annotations

import sys

import typer

from tsd_casadi.exceptions import TsdError
from tsd_cli.commands.calibrate import calibrate
from tsd_cli.commands.experiments import demo, reproduce
from tsd_cli.commands.learn import learn
from tsd_cli.commands.query import forget_entry, list_entries, query
from tsd_cli.commands.services import controller, learner
from tsd_cli.commands.simulate import simulate

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    help="""Whole-body control that learns task-specific dynamics.

    Start [bold]tsd controller[/bold] and [bold]tsd learner[/bold] in two terminals, then
    [bold]tsd learn squat[/bold] in a third and [bold]tsd query squat --amplitude 0.05[/bold].
    [bold]tsd demo[/bold] does all of it by itself in a few minutes.

    Amplitudes are metres (half of peak to peak), frequencies hertz. Exit codes: 0 done,
    1 refused or failed, 2 wrong usage, 3 the robot fell, 130 interrupted.""",
)
database_app = typer.Typer(no_args_is_help=True, help="Look at what the learner knows.")
app.add_typer(database_app, name="database")
for command in (controller, learner, simulate, learn, calibrate, query, demo, reproduce):
    app.command()(command)
database_app.command("list")(list_entries)
database_app.command("forget")(forget_entry)


def main() -> None:
    """Run the command line; errors are one message on stderr, not a traceback."""
    try:
        app()
    except TsdError as error:
        typer.echo(f"error: {error}", err=True)
        sys.exit(1)


if __name__ == "__main__":
    main()
