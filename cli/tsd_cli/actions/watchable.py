"""A run that others can watch, unless the user does not want it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import typer

from tsd_casadi.robot.robot import Robot
from tsd_cli.options.telemetry import TelemetryOptions
from tsd_clients.telemetry.telemetry import Telemetry


@contextmanager
def watchable(
    options: TelemetryOptions, robot: Robot, settings: Mapping[str, Any]
) -> Iterator[Telemetry | None]:
    """Let others watch until the end; what keeps them from it is said, and nothing more.

    Args:
        settings: What who watches should know of the run.

    Yields:
        The observer that publishes; None if nobody is to watch, or nobody can.
    """
    if not options.telemetry:
        yield None
        return
    try:
        telemetry = Telemetry(robot.name, settings)
    except OSError as error:
        _tell(str(error))
        yield None
        return
    try:
        with telemetry:
            yield telemetry
    finally:
        if telemetry.trouble:
            _tell(telemetry.trouble)


def _tell(trouble: str) -> None:
    typer.echo(f"note: nobody could watch: {trouble}", err=True)
