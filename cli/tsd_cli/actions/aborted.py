"""A run that something ended early: what there is of it is kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import typer

from tsd_casadi.exceptions import TsdError
from tsd_casadi.repetition.run import Run

FELL = 3
ABORTED = 4


@contextmanager
def keep_aborted(
    put_out: Callable[[Run], None], files: Sequence[str]
) -> Iterator[Callable[[Run], None]]:
    """Put out what was run of a repetition before an error or the user ended it.

    Args:
        put_out: Shows and writes it.
        files: Where to, for people.

    Yields:
        What is to be called with such a run.

    Raises:
        typer.Exit: If an error ended it; Ctrl-C goes on as it is.
    """
    kept: list[Run] = []
    try:
        yield kept.append
    except (TsdError, KeyboardInterrupt) as error:
        if not kept:
            raise
        put_out(kept[0])
        kept_in = f", kept in {' and '.join(files)}" if files else "; --log and --json keep them"
        typer.echo(f"note: aborted after {kept[0].ticks} periods{kept_in}", err=True)
        if isinstance(error, KeyboardInterrupt):
            raise
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(ABORTED) from error


@contextmanager
def put_out_on_interrupt(put_out: Callable[[], None]) -> Iterator[None]:
    """Put out what there is when Ctrl-C is pressed, which then goes on as it is."""
    try:
        yield
    except KeyboardInterrupt:
        put_out()
        raise
