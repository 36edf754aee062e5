"""Progress on stderr, so that stdout stays machine-readable."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

console = Console(stderr=True)


@contextmanager
def show_activity(text: str) -> Iterator[None]:
    """Show that something of unknown length is under way."""
    if not console.is_terminal:
        console.print(f"{text} ...")
        yield
        return
    columns = (SpinnerColumn(), TextColumn(text), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        progress.add_task(text, total=None)
        yield


@contextmanager
def show_progress(text: str, total: float) -> Iterator[Callable[[float, float], None]]:
    """Show a bar; nothing where stderr is no terminal.

    Yields:
        Function (done, total) that moves the bar.
    """
    if not console.is_terminal:
        yield lambda done, total: None
        return
    columns = (TextColumn(text), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task(text, total=total)

        def update(done: float, total: float) -> None:
            progress.update(task, completed=done, total=total)

        yield update
