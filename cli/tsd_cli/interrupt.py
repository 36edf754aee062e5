"""Ctrl-C as an exception while something is open, as the end of the process otherwise."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager

import typer

INTERRUPTED = 130


@contextmanager
def interruptible(remark: str = "") -> Iterator[None]:
    """Close what is open when Ctrl-C is pressed, then exit with 130.

    To be entered when all modules are loaded: an exception in the middle of an
    import may end anywhere, the signal's own way of ending the process may not.

    Args:
        remark: What the user should know then.

    Raises:
        typer.Exit: On Ctrl-C.
    """
    if signal.getsignal(signal.SIGINT) is not signal.SIG_DFL:
        yield  # ignored, or in the hands of whoever called us
        return
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        yield
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        typer.echo("interrupted" + (f"; {remark}" if remark else ""), err=True)
        raise typer.Exit(INTERRUPTED) from None
    finally:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
