"""What commands print and write."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import typer

from tsd_casadi.exceptions import InvalidValue
from tsd_casadi.repetition.run import Run


def put_out(result: dict[str, Any], json_file: str | None, show: Callable[[], object]) -> None:
    """Show a result, or write it as JSON.

    Args:
        result: Plain data.
        json_file: File to write as well; '-' for stdout instead of a table.
        show: Prints the table.
    """
    if json_file == "-":
        typer.echo(json.dumps(result, indent=2))
        return
    show()
    if json_file is not None:
        Path(json_file).write_text(json.dumps(result, indent=2))


def check_writable(*targets: str | Path | None) -> None:
    """Refuse a file that cannot be written before the work, not after it.

    Args:
        targets: Files; None and '-' are fine.

    Raises:
        InvalidValue: If one cannot be written.
    """
    for target in targets:
        if target is None or target == "-":
            continue
        try:
            with Path(target).open("a"):
                pass
        except OSError as error:
            raise InvalidValue(
                "output file", f"'{target}' ({error.strerror})", "a writable path"
            ) from error


def label_of(run: Run) -> str:
    """What a run is called in a table.

    Args:
        run: The run.
    """
    parts = [f"{run.motion.name} {100 * run.motion.parameters['amplitude']:g} cm"]
    kind = run.feedforward.kind
    parts.append(f"{kind}, iteration {run.feedforward.iteration}" if kind != "none" else "none")
    if run.settings["p_scale"] != 1.0:
        parts.append(f"P x {run.settings['p_scale']:g}")
    if run.settings["hardware"]:
        parts.append("hardware")
    return ", ".join(parts)
