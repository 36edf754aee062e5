"""'tsd database export', 'import' and 'verify': files of what was learned."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsd_cli.option_groups import with_groups

Database = Annotated[
    Path | None,
    typer.Option(
        "--database",
        metavar="FILE",
        help="The learner's file on this machine. Default: in the user's data folder.",
    ),
]


@with_groups
def export_entries(
    target: Annotated[Path, typer.Argument(metavar="TARGET", help="File that is made.")],
    database: Database = None,
) -> None:
    """Write all entries into a file for another machine.

    tsd database export learned.json
    tsd database export learned.json --database squats.sqlite
    """
    from tsd_cli.actions.database import export

    export(target, database)


@with_groups
def import_entries(
    source: Annotated[Path, typer.Argument(metavar="SOURCE", help="File from 'export'.")],
    database: Database = None,
) -> None:
    """Take in what was learned elsewhere; an entry that is here already stays as it is.

    tsd database import learned.json
    """
    from tsd_cli.actions.database import take_in

    take_in(source, database)


@with_groups
def verify_database(database: Database = None) -> None:
    """Read every row of a database and compare it with its checksum.

    tsd database verify
    tsd database verify --database squats.sqlite
    """
    from tsd_cli.actions.database import verify

    verify(database)
