"""Which entries are listed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import typer

from tsd_casadi.wire.listing import LARGEST_PAGE

# what a screen or two show; the command says how many more there are
USUAL = 40


@dataclass(frozen=True, kw_only=True)
class ListingOptions:
    """Entries."""

    robot: Annotated[
        str | None, typer.Option("--robot", metavar="NAME", help="Only of this robot.")
    ] = None
    motion: Annotated[
        str | None, typer.Option("--motion", metavar="NAME", help="Only of this motion.")
    ] = None
    limit: Annotated[
        int,
        typer.Option(
            "--limit",
            min=1,
            max=LARGEST_PAGE,
            help="At most so many, those that were recorded last; --json has all.",
        ),
    ] = USUAL
