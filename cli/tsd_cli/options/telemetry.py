"""Whether others can watch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import typer


@dataclass(frozen=True, kw_only=True)
class TelemetryOptions:
    """Watching."""

    telemetry: Annotated[
        bool,
        typer.Option(
            "--telemetry/--no-telemetry",
            help="Let 'tsd view' and other programs of yours on this machine watch.",
        ),
    ] = True
