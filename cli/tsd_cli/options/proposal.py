"""What a proposed robot file is made of."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer


@dataclass(frozen=True, kw_only=True)
class ProposalOptions:
    """Proposal."""

    feet: Annotated[
        str,
        typer.Option(
            "--feet",
            metavar="LEFT,RIGHT",
            help="Links of the left and of the right foot, or frames on them.",
        ),
    ]
    lock: Annotated[
        list[str] | None,
        typer.Option(
            "--lock",
            metavar="REGEX",
            help="Joints that are not to move: a name, or a pattern that matches whole names, "
            "such as '.*_hand_.*'; may be given several times.",
        ),
    ] = None
    package: Annotated[
        str | None,
        typer.Option(
            "--package",
            metavar="NAME",
            help="Robot of the package example-robot-data, such as g1, instead of FILE; with "
            "FILE the one of its descriptions that ends with that.",
        ),
    ] = None
    name: Annotated[
        str | None,
        typer.Option("--name", metavar="NAME", help="Of the robot; by default the file's."),
    ] = None
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="FILE",
            help="Robot file to write, in a folder above its description; by default NAME.yaml "
            "here if that is one, else beside the description.",
        ),
    ] = None
    force: Annotated[
        bool, typer.Option("--force", help="Write over a robot file that is there.")
    ] = False
