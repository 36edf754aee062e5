"""Looking at logs, for the command line."""

from __future__ import annotations

from pathlib import Path

import typer

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.whole_file import check_writable
from tsd_cli.interrupt import interruptible
from tsd_cli.options.output import JsonOptions
from tsd_cli.output import check_outputs, put_out
from tsd_clients.console.log_tables import print_log
from tsd_clients.logs.convert_log import write_any_log
from tsd_clients.logs.cut_log import cut_log, ticks_between, ticks_of_laps
from tsd_clients.logs.log_file import check_log_path
from tsd_clients.logs.plot_log import check_picture_path, plot_log
from tsd_clients.logs.read_log import read_log
from tsd_clients.logs.recover_log import recover_log
from tsd_clients.logs.summarize_log import summarize_log


@interruptible()
def show(path: Path, output: JsonOptions) -> None:
    """Summarise a log.

    Raises:
        TsdError: If it cannot be read.
    """
    check_outputs(output)
    found = {"file": str(path), **summarize_log(read_log(path))}
    put_out(found, output, lambda: print_log(path.name, found))


@interruptible()
def cut(
    path: Path, target: Path, first: float | None, last: float | None, laps: str | None
) -> None:
    """Write a part of a log into another file.

    Raises:
        TsdError: If the log cannot be read, has no such part, or the target cannot be
            written.
    """
    if laps is not None and (first is not None or last is not None):
        raise InvalidValue("part of the log", "by time and by laps", "--from and --to, or --laps")
    if laps is None and first is None and last is None:
        raise InvalidValue("part of the log", "not said", "--from, --to or --laps")
    span = None if laps is None else _lap_span(laps)
    _check_target(path, target)
    log = read_log(path)
    ticks = ticks_between(log, first, last) if span is None else ticks_of_laps(log, *span)
    cut_log(path, target, log, ticks)
    typer.echo(f"{target}: {ticks.sum()} of {log.ticks} ticks")


@interruptible()
def convert(path: Path, target: Path) -> None:
    """Write a log in another format.

    Raises:
        TsdError: If the log cannot be read, or the target not be written.
    """
    _check_target(path, target)
    log = read_log(path)
    write_any_log(log, target)
    typer.echo(f"{target}: {log.ticks} ticks")


@interruptible()
def plot(path: Path, picture: Path | None) -> None:
    """Draw a log.

    Raises:
        TsdError: If the log cannot be read, or the picture not be written.
    """
    target = path.with_suffix(".png") if picture is None else picture
    check_picture_path(target)
    check_writable(target)
    plot_log(read_log(path), target)
    typer.echo(f"{target}")


@interruptible()
def recover(path: Path, out: Path | None) -> None:
    """Make a log whole.

    Raises:
        TsdError: If there is nothing to keep, or the file cannot be written.
    """
    target = path if out is None else out
    check_writable(target)
    size = path.stat().st_size
    copied = recover_log(path, target)
    if copied.is_whole and not copied.damaged:
        typer.echo(f"{path} is whole: {copied.ticks} ticks")
        return
    lost = f"{size - copied.read} bytes at its end lost"
    if copied.damaged:
        lost += f", {copied.damaged} damaged chunks left out"
    typer.echo(f"{target}: {copied.ticks} ticks kept, {lost}")


def _check_target(path: Path, target: Path) -> None:
    check_log_path(target)
    check_writable(target)
    if target.exists() and path.exists() and target.samefile(path):
        raise InvalidValue("target", f"'{target}', the log itself", "another file")


def _lap_span(text: str) -> tuple[int, int]:
    first, _, last = text.partition(":")
    try:
        span = int(first), int(last or first)
    except ValueError:
        span = 0, -1
    if not 0 <= span[0] <= span[1]:
        raise InvalidValue("laps", f"'{text}'", "FIRST:LAST, such as 1:2, or one number")
    return span
