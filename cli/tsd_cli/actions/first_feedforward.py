"""What a motion of which nothing is known starts with."""

from __future__ import annotations

import typer

from tsd_casadi.exceptions import EntryNotFound
from tsd_casadi.learning.context import Context
from tsd_casadi.learning.feedforward import Feedforward
from tsd_casadi.motions.motion import Motion
from tsd_casadi.robot.robot import Robot
from tsd_cli.options.learning import FirstChoice
from tsd_clients.remote.remote_learner import RemoteLearner


def ask_first(
    choice: FirstChoice,
    learner: RemoteLearner,
    robot: Robot,
    axes: tuple[str, ...],
    context: Context,
    motion: Motion,
) -> Feedforward | None:
    """Choose what a motion of which nothing is known starts with."""
    if choice is FirstChoice.NONE:
        return None
    try:
        return learner.query(
            motion.name,
            robot=robot.name,
            kind=choice.value,
            extrapolate=True,
            axes=axes,
            context=context,
            version=motion.version,
            **motion.parameters,
        )
    except EntryNotFound as error:
        typer.echo(f"note: nothing to generalise from yet ({error})", err=True)
        return None
