"""What commands print and write."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import typer

from tsd_casadi.whole_file import check_writable, write_whole
from tsd_cli.options.output import JsonOptions

STDOUT = "-"


def put_out(result: dict[str, Any], options: JsonOptions, show: Callable[[], object]) -> None:
    """Show a result, or write it as JSON; '-' is stdout, instead of a table.

    Args:
        result: Plain data.
        show: Prints the table.

    Raises:
        InvalidValue: If the file cannot be written.
    """
    text = json.dumps(result, indent=2)
    if options.json_file == STDOUT:
        typer.echo(text)
        return
    show()
    if options.json_file is not None:
        with write_whole(options.json_file) as file:
            file.write(text.encode() + b"\n")


def check_outputs(options: JsonOptions, *files: Path | None) -> None:
    """Refuse files that could not be written, before the work rather than after it.

    Raises:
        InvalidValue: If one cannot be written.
    """
    if options.json_file not in (None, STDOUT):
        check_writable(str(options.json_file))
    for file in files:
        if file is not None:
            check_writable(file)
