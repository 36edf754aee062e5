"""Where the live page is, and what it shows."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

LOOPBACK = "127.0.0.1"


@dataclass(frozen=True, kw_only=True)
class PageOptions:
    """Page."""

    port: Annotated[
        int,
        typer.Option(
            "--port", metavar="PORT", min=1, max=65535, help="The next free one if it is taken."
        ),
    ] = 8080
    listen_on: Annotated[
        str,
        typer.Option(
            "--host",
            metavar="ADDRESS",
            help="Address of this machine that others reach, and with it everybody in its "
            "network: there is no password. By default only this machine sees the page.",
        ),
    ] = LOOPBACK
    allow_run: Annotated[
        bool,
        typer.Option(
            "--allow-run",
            help="Buttons in the explorer that simulate and learn as you. Whoever reaches the page "
            "may press them: only without --host.",
        ),
    ] = False
    browse: Annotated[bool, typer.Option("--open", help="Open the page in a browser.")] = False


@dataclass(frozen=True, kw_only=True)
class ReplayOptions:
    """Replay."""

    log: Annotated[
        Path | None,
        typer.Option(
            "--log",
            metavar="FILE",
            help="Play a log instead of showing what runs: .npz, .mcap or .csv.",
        ),
    ] = None
    robot: Annotated[
        str | None,
        typer.Option(
            "--robot",
            metavar="ROBOT",
            help="Name of a shipped robot, or path of a robot file (.yaml); by default the log's.",
        ),
    ] = None
