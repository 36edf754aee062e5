"""Files of what was learned: written, taken in and checked, without any service."""

from __future__ import annotations

from pathlib import Path

import typer

from tsd_casadi.database.database import Database, default_path
from tsd_casadi.exceptions import InvalidValue
from tsd_cli.interrupt import interruptible
from tsd_cli.options.output import JsonOptions
from tsd_cli.output import check_outputs

DAMAGED = 1


@interruptible()
def export(target: Path, path: Path | None) -> None:
    """Write all entries into a file.

    Raises:
        TsdError: If the database cannot be read, or the file not be written.
    """
    check_outputs(JsonOptions(), target)
    with _open(path) as database:
        count = database.export(target)
        typer.echo(f"wrote {count} entries of {database.path} to {target}")
        for each in database.damaged():
            typer.echo(f"note: entry {each.identifier} is damaged and left out", err=True)


@interruptible("either all of the file was taken in or nothing")
def take_in(source: Path, path: Path | None) -> None:
    """Add the entries of a file that are not there yet.

    Raises:
        TsdError: If the file or the database cannot be used.
    """
    if not source.is_file():  # before a database is made for nothing
        raise InvalidValue(
            "source", f"'{source}', which is no file", "one of 'tsd database export'"
        )
    with Database(path or default_path()) as database:
        taken = database.import_(source)
        typer.echo(
            f"{database.path}: {taken.added} entries added, {taken.skipped} were there already"
        )


@interruptible()
def verify(path: Path | None) -> None:
    """Check everything, and list what is wrong.

    Raises:
        TsdError: If the database cannot be opened.
        typer.Exit: If something is wrong.
    """
    with _open(path) as database:
        damages = database.verify()
        for damage in damages:
            typer.echo(damage)
        if damages:
            raise typer.Exit(DAMAGED)
        typer.echo(f"{database.path}: {len(database.entries())} entries, nothing wrong")


def _open(path: Path | None) -> Database:
    """Open a database that is there; none is made."""
    found = (path or default_path()).expanduser()
    if not found.is_file():
        raise InvalidValue("database", f"'{found}', which is no file", "one of 'tsd learner'")
    return Database(found)
