"""How time passes, and how long a controller may be silent."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import typer

from tsd_casadi.repetition.patience import PATIENCE


@dataclass(frozen=True, kw_only=True)
class PaceOptions:
    """Time."""

    pace: Annotated[
        float | None,
        typer.Option(
            "--pace",
            metavar="FACTOR",
            help="Against the clock: 1 is real time, 0.5 half speed. A period without an answer "
            "is stepped with the robot's fallback and counted. Default: simulated time waits for "
            "every answer.",
        ),
    ] = None
    patience: Annotated[
        float,
        typer.Option(
            "--patience",
            metavar="SECONDS",
            help="How long the controller may be silent before the run is given up; inf for ever.",
        ),
    ] = PATIENCE
