"""What the learner knows: a table of the newest, all of it as JSON, less an entry."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING

import typer

from tsd_casadi.whole_file import write_whole
from tsd_cli.actions.open_learner import open_learner
from tsd_cli.interrupt import interruptible
from tsd_cli.options.listing import ListingOptions
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.services import ConnectOptions
from tsd_cli.output import STDOUT, check_outputs
from tsd_clients.console.learner_tables import describe_parameters, print_entries

if TYPE_CHECKING:
    from tsd_clients.remote.remote_learner import RemoteLearner


@interruptible()
def list_entries(listing: ListingOptions, services: ConnectOptions, output: JsonOptions) -> None:
    """List what was learned.

    Raises:
        TsdError: If the learner cannot be reached, or the file not be written.
    """
    check_outputs(output)
    with open_learner(services) as learner:
        if output.json_file == STDOUT:
            for text in _document(learner, listing):
                typer.echo(text, nl=False)
            return
        print_entries(learner.database(listing.robot, listing.motion, limit=listing.limit))
        if output.json_file is not None:
            with write_whole(output.json_file) as file:
                for text in _document(learner, listing):
                    file.write(text.encode())


@interruptible()
def forget(entry: int, services: ConnectOptions) -> None:
    """Remove an entry and say what it was.

    Raises:
        TsdError: If there is none of that number, or the learner cannot be reached.
    """
    with open_learner(services) as learner:
        forgotten = learner.forget(entry).forgotten
    if forgotten is None:
        typer.echo(f"forgot entry {entry}, which could not be read")
    else:
        typer.echo(
            f"forgot entry {forgotten.entry}: {forgotten.motion} of {forgotten.robot}, "
            f"{describe_parameters(forgotten)}"
        )


def _document(learner: RemoteLearner, listing: ListingOptions) -> Iterator[str]:
    """Write all that is known as one reply, an entry a line, page by page."""
    between, damaged = "", []
    for page in learner.pages(listing.robot, listing.motion):
        if not between:
            named = {"format": page.format, "instance": page.instance, "database": page.database}
            yield json.dumps(named)[:-1] + ', "entries": ['
        for entry in page.entries:
            yield f"{between}\n{entry.model_dump_json()}"
            between = ","
        between = between or " "
        damaged += [each.model_dump(mode="json") for each in page.damaged]
    yield f'\n], "damaged": {json.dumps(damaged)}, "more": 0, "forgotten": null}}\n'
