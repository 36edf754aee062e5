"""Which robot, and how the simulated one differs from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import typer

from tsd_clients.simulator.effects import EFFECTS


@dataclass(frozen=True, kw_only=True)
class RobotOptions:
    """Robot."""

    robot: Annotated[
        str,
        typer.Option(
            "--robot",
            metavar="ROBOT",
            help="Name of a shipped robot, or path of a robot file (.yaml).",
        ),
    ] = "hermes_lower"


@dataclass(frozen=True, kw_only=True)
class SimulatedRobotOptions(RobotOptions):
    """Simulated robot."""

    model_error: Annotated[
        float,
        typer.Option(
            "--model-error",
            metavar="SHARE",
            help="E: the controller's masses and inertias are 1 + E times the simulated "
            "robot's, and the controller is not told; 0.1 is 10 %.",
        ),
    ] = 0.0
    link_error: Annotated[
        float,
        typer.Option(
            "--link-error",
            metavar="SHARE",
            help="A further error with random sign on each link; 0.1 is 10 %.",
        ),
    ] = 0.0
    link_seed: Annotated[
        int, typer.Option("--link-seed", metavar="N", min=0, help="Of those signs.")
    ] = 0
    hardware: Annotated[
        str,
        typer.Option(
            "--hardware",
            metavar="EFFECTS",
            help="What the simulated robot has beyond rigid bodies: all, or a list such as "
            f"friction,lag out of {', '.join(EFFECTS)}. Numbers: section hardware of the "
            "robot file.",
        ),
    ] = ""
