"""Which motion, and how it is repeated."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

Amplitude = Annotated[
    float,
    typer.Option("--amplitude", metavar="METRES", help="Half of peak to peak; 0.03 is 3 cm."),
]


@dataclass(frozen=True, kw_only=True)
class AskedMotion:
    """Motion."""

    motion: Annotated[str, typer.Argument(metavar="MOTION", help="The motion: squat.")]
    amplitude: Amplitude
    frequency: Annotated[
        float, typer.Option("--frequency", metavar="HERTZ", help="Laps per second.")
    ] = 0.25
    height: Annotated[
        float,
        typer.Option("--height", metavar="METRES", help="Middle of the motion above home."),
    ] = 0.0


@dataclass(frozen=True, kw_only=True)
class MotionOptions(AskedMotion):
    """Motion."""

    amplitude: Amplitude = 0.03


@dataclass(frozen=True, kw_only=True)
class RepetitionOptions:
    """Repetition."""

    laps: Annotated[
        int,
        typer.Option(
            "--laps", metavar="N", help="Least number of laps; more are added until steady."
        ),
    ] = 3
    p_scale: Annotated[
        float, typer.Option("--p-scale", metavar="FACTOR", help="Factor on the learned task's P.")
    ] = 1.0
    d_scale: Annotated[
        float, typer.Option("--d-scale", metavar="FACTOR", help="Factor on the learned task's D.")
    ] = 1.0
    com_correction: Annotated[
        Path | None,
        typer.Option(
            "--com-correction",
            metavar="FILE",
            help="Corrected centre of mass, from 'tsd calibrate'.",
        ),
    ] = None
    seed: Annotated[
        int,
        typer.Option("--seed", metavar="N", min=0, help="Of the starting posture's randomness."),
    ] = 0


class FeedforwardChoice(StrEnum):
    """What is fed forward."""

    NONE = "none"
    LEARNED = "learned"
    GENERALIZED = "generalised"


@dataclass(frozen=True, kw_only=True)
class SingleRepetitionOptions(RepetitionOptions):
    """Repetition."""

    feedforward: Annotated[
        FeedforwardChoice,
        typer.Option(
            "--feedforward",
            metavar="KIND",
            help="none, or from the learner: learned is the exact entry, generalised a regression "
            "over the others.",
        ),
    ] = FeedforwardChoice.NONE
