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
    entry: Annotated[
        list[int] | None,
        typer.Option(
            "--entry", metavar="N", help="Only this entry; repeat for more. Default: all."
        ),
    ] = None,
) -> None:
    """Write entries into a file for another machine.

    tsd database export squats.tsd
    tsd database export squats.tsd --entry 3 --entry 4
    """
    from tsd_cli.actions.database import export

    export(target, database, entry)


@with_groups
def import_entries(
    source: Annotated[Path, typer.Argument(metavar="SOURCE", help="File from 'export'.")],
    database: Database = None,
) -> None:
    """Take in what was learned elsewhere; an entry that is here already stays as it is.

    tsd database import squats.tsd
    """
    from tsd_cli.actions.database import import_

    import_(source, database)


@with_groups
def verify_database(database: Database = None) -> None:
    """Read every row of a database and compare it with its checksum.

    tsd database verify
    tsd database verify --database squats.sqlite
    """
    from tsd_cli.actions.database import verify

    verify(database)
