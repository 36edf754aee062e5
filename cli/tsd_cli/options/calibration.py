"""How the centre of mass is measured, and what is known before."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from tsd_casadi.center_of_mass.mass_prior import NOISE, MassPrior


@dataclass(frozen=True, kw_only=True)
class CalibrationOptions:
    """Calibration."""

    out: Annotated[
        Path, typer.Option("--out", metavar="FILE", help="File for the correction (JSON).")
    ]
    poses: Annotated[
        int,
        typer.Option(
            "--poses", metavar="N", help="Number of static poses; each takes about 2.5 s."
        ),
    ] = 30
    noise: Annotated[
        float,
        typer.Option(
            "--noise",
            metavar="METRES",
            min=1e-6,
            help="Standard deviation of a pose's averaged centre of pressure; added to the "
            "simulated one and known to the fit.",
        ),
    ] = NOISE
    inclinometer: Annotated[
        float | None,
        typer.Option(
            "--inclinometer",
            metavar="RADIANS",
            min=0.0,
            help="Standard deviation of an inclinometer on the base, such as 1e-4; "
            "without one the joint angles tell the base's lean, if hardware says so.",
        ),
    ] = None
    mass_prior: Annotated[
        float,
        typer.Option(
            "--mass-prior",
            metavar="SHARE",
            help="How far each link's mass may be off; 0.1 is 10 %.",
        ),
    ] = MassPrior.mass
    center_prior: Annotated[
        float,
        typer.Option(
            "--center-prior",
            metavar="METRES",
            help="How far each link's centre of mass may be off.",
        ),
    ] = MassPrior.center
    seed: Annotated[
        int, typer.Option("--seed", metavar="N", min=0, help="Of poses, start and sensor noise.")
    ] = 0
