"""Where the services are."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from tsd_casadi.wire.endpoints import CONTROLLER, LEARNER
from tsd_casadi.wire.zenoh_file import ZenohFile, read_zenoh_file


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
    zenoh_config: Annotated[
        Path | None,
        typer.Option(
            "--zenoh-config",
            metavar="FILE",
            help="A Zenoh configuration with what another computer asks for: certificates, "
            "user names, routers.",
        ),
    ] = None

    def zenoh_file(self) -> ZenohFile | None:
        """Read the configuration, if one was named.

        Raises:
            InvalidValue: If it cannot be read.
        """
        return None if self.zenoh_config is None else read_zenoh_file(self.zenoh_config)

    def endpoints(self, usual: str) -> list[str]:
        """List where a service is looked for.

        Args:
            usual: Where, if neither an option nor the configuration says so.
        """
        if self.connect:
            return self.connect
        file = self.zenoh_file()
        return (file.endpoints("connect") if file is not None else []) or [usual]


class LogLevel(StrEnum):
    """What a service tells."""

    DEBUG = "debug"
    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True, kw_only=True)
class ListenOptions:
    """Network."""

    listen: Annotated[
        list[str] | None,
        typer.Option(
            "--listen",
            metavar="ENDPOINT",
            help="Endpoint to listen on; repeat for more than one. Default: "
            f"{CONTROLLER} for the controller, {LEARNER} for the learner.",
        ),
    ] = None
    zenoh_config: Annotated[
        Path | None,
        typer.Option(
            "--zenoh-config",
            metavar="FILE",
            help="A Zenoh configuration: certificates, user names, routers.",
        ),
    ] = None
    expose: Annotated[
        bool,
        typer.Option(
            "--expose", help="Let other machines in that reach the endpoint, without such a file."
        ),
    ] = False
    log_level: Annotated[
        LogLevel | None,
        typer.Option("--log-level", help="What to tell on stderr. Default: warning."),
    ] = None
    verbose: Annotated[bool, typer.Option("--verbose", help="The same as --log-level info.")] = (
        False
    )


@dataclass(frozen=True, kw_only=True)
class ServiceOptions(ConnectOptions):
    """Services."""

    controller: Annotated[
        ControllerChoice, typer.Option("--controller", help="The service, or this process.")
    ] = ControllerChoice.ZENOH
