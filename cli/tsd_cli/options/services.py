"""Where the services are."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated

import typer

from tsd_casadi.wire.endpoints import CONTROLLER, LEARNER


class ControllerChoice(StrEnum):
    """Where the controller runs."""

    ZENOH = "zenoh"
    LOCAL = "local"


@dataclass(frozen=True, kw_only=True)
class ConnectOptions:
    """Services."""

    connect: Annotated[
        list[str] | None,
        typer.Option(
            "--connect",
            metavar="ENDPOINT",
            help="Endpoint of a service; repeat for controller and learner. "
            f"Default: {CONTROLLER} and {LEARNER}.",
        ),
    ] = None


@dataclass(frozen=True, kw_only=True)
class ServiceOptions(ConnectOptions):
    """Services."""

    controller: Annotated[
        ControllerChoice, typer.Option("--controller", help="The service, or this process.")
    ] = ControllerChoice.ZENOH
