"""Which motion, and how it is repeated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

CorrectionFile = Annotated[
    Path | None,
    typer.Option(
        "--com-correction",
        metavar="FILE",
        help="Corrected centre of mass, from 'tsd calibrate'.",
    ),
]


@dataclass(frozen=True, kw_only=True)
class MotionOptions:
    """Motion."""

    motion: Annotated[
        str,
        typer.Argument(
            metavar="MOTION",
            help="Name of a motion ('tsd motion list'), a class in a file of your own "
            "(my_motion.py:Bounce), or a file with references (wave.csv). Behind it, -h tells "
            "its parameters as well.",
        ),
    ]
    axes: Annotated[
        str | None,
        typer.Option(
            "--axes",
            metavar="TASK.AXIS,...",
            help="What is learned, such as com.z or com.x,torso.rz. Default: what moves, and all "
            "of the centre of mass.",
        ),
    ] = None
    # options of the motion that was named, see ``motion_parameters``
    parameters: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class RepetitionOptions:
    """Repetition."""

    laps: Annotated[
        int,
        typer.Option(
            "--laps", metavar="N", help="Least number of laps; more are added until steady."
        ),
    ] = 3
    period: Annotated[
        float,
        typer.Option(
            "--period",
            metavar="SECONDS",
            help="Control period, 0.00025 to 0.005.",
        ),
    ] = 1e-3
    p_scale: Annotated[
        float, typer.Option("--p-scale", metavar="FACTOR", help="Factor on the learned tasks' P.")
    ] = 1.0
    d_scale: Annotated[
        float, typer.Option("--d-scale", metavar="FACTOR", help="Factor on the learned tasks' D.")
    ] = 1.0
    com_correction: CorrectionFile = None
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
