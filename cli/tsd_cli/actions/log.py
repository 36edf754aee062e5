"""Looking at logs, for the command line."""

from __future__ import annotations

from pathlib import Path

from tsd_cli.interrupt import interruptible
from tsd_cli.options.output import JsonOptions
from tsd_cli.output import check_outputs, put_out
from tsd_clients.console.log_tables import print_log
from tsd_clients.logs.read_log import read_log
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
