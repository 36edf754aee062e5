"""How learning goes on, and where."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated

import typer


class RuleChoice(StrEnum):
    """How learning goes on from one iteration to the next."""

    GUARDED = "guarded"
    PLAIN = "plain"
    STABLE = "stable"
    ADAPTIVE = "adaptive"


class FirstChoice(StrEnum):
    """What a motion of which nothing is known starts with."""

    NONE = "none"
    GENERALIZED = "generalised"


@dataclass(frozen=True, kw_only=True)
class LearningOptions:
    """Learning."""

    iterations: Annotated[
        int,
        typer.Option(
            "--iterations", metavar="N", help="N iterations are N + 1 runs, the last evaluates."
        ),
    ] = 1
    restart: Annotated[
        bool, typer.Option("--restart", help="Forget what was learned of this motion first.")
    ] = False
    rule: Annotated[
        RuleChoice,
        typer.Option(
            "--rule",
            metavar="RULE",
            help="plain: the paper's sum. guarded: the same, never going on from what proved "
            "worse. stable: guarded, with phase lead and bandwidth from the response that the "
            "repetitions show, so that lag and delay let nothing grow; prints by harmonic what "
            "an iteration leaves of the error. adaptive: stable, going by how much of the last "
            "change arrived, for joints in which friction takes most of it.",
        ),
    ] = RuleChoice.ADAPTIVE
    stop_after: Annotated[
        int | None,
        typer.Option(
            "--stop-after",
            metavar="N",
            min=1,
            help="Stop after so many iterations in a row without a smaller error. Default: "
            "3 with --rule stable, 3 with --rule adaptive, else never.",
        ),
    ] = None
    first: Annotated[
        FirstChoice,
        typer.Option(
            "--first",
            metavar="KIND",
            help="What a motion of which nothing is known starts with: none, or generalised, the "
            "learner's regression, extrapolated if need be and dropped if it harms.",
        ),
    ] = FirstChoice.NONE


@dataclass(frozen=True, kw_only=True)
class PlaceOptions:
    """Where to learn."""

    auto: Annotated[
        int,
        typer.Option(
            "--auto",
            metavar="N",
            min=0,
            help="Learn at so many places of the region, each time where the learner is most "
            "uncertain, instead of at the one given.",
        ),
    ] = 0
    region: Annotated[
        list[str] | None,
        typer.Option(
            "--region",
            metavar="NAME=LOW:HIGH",
            help="Range to choose from, as amplitude=0.02:0.08; repeat for more parameters. "
            "NAME alone is from a quarter of the robot's largest value to the largest, and all "
            "of the robot's range where zero lies inside it. Default: amplitude.",
        ),
    ] = None
