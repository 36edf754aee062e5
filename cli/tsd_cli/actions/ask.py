"""Asking the learner what to feed forward."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from tsd_casadi.center_of_mass.correction import CenterOfMassCorrection
from tsd_casadi.learning.axis_error import unit_of_axis
from tsd_casadi.learning.circumstances import tell_differences
from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.repetition.record import context_of
from tsd_casadi.robot.robot import load_robot
from tsd_casadi.wire.feedforward import FeedforwardMessage
from tsd_cli.actions.open_learner import open_learner
from tsd_cli.actions.prepare import asked_motion, chosen_axes
from tsd_cli.interrupt import interruptible
from tsd_cli.options.motion import MotionOptions
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.robot import RobotOptions
from tsd_cli.options.services import ConnectOptions
from tsd_cli.output import check_outputs, put_out
from tsd_clients.console.learner_tables import (
    describe_context,
    describe_values,
)
from tsd_clients.console.table import console


@interruptible()
def ask_feedforward(
    motion: MotionOptions,
    robot: RobotOptions,
    kind: str | None,
    extrapolate: bool,
    com_correction: Path | None,
    services: ConnectOptions,
    output: JsonOptions,
) -> None:
    """Ask for a feedforward and show it.

    Args:
        com_correction: With which it was learned; None for the model's centre of mass.

    Raises:
        TsdError: If the learner has none, or cannot be reached.
    """
    check_outputs(output)
    loaded = load_robot(robot.robot)
    wanted = asked_motion(motion, loaded)
    axes = chosen_axes(motion, loaded, wanted)
    correction = ""
    if com_correction is not None:
        correction = CenterOfMassCorrection.load(loaded, com_correction).fingerprint
    with open_learner(services) as learner:
        message = learner.query_message(
            wanted.name,
            robot=loaded.name,
            kind=kind,
            extrapolate=extrapolate,
            axes=axes,
            context=context_of(loaded, correction),
            version=wanted.version,
            **wanted.parameters,
        )
    put_out(json.loads(message.encode()), output, lambda: _print_feedforward(message))


def _print_feedforward(message: FeedforwardMessage) -> None:
    feedforward = message.feedforward()
    declaration = feedforward.declaration or Declaration.unknown(message.motion)
    parameters = describe_values(declaration, feedforward.parameters)
    axes = ", ".join(feedforward.axes)
    console.print(f"{feedforward.kind} feedforward along {axes} for {parameters}")
    source = "entries {entries}, iteration {iteration}".format(**feedforward.provenance)
    console.print(f"from {source}; the whole answer: --json -")
    for left_out in feedforward.provenance.get("disagreeing", []):
        console.print(
            "without entry {entry}: the others contradict it, it is {deviations} standard "
            "deviations off; learn it again, or forget it".format(**left_out)
        )
    if differences := tell_differences(feedforward.provenance.get("hardware", ())):
        console.print(
            f"those entries were learned on robots that differ ({differences}): learn those of "
            "the robot of before again, or forget them"
        )
    others = f"; {message.others} entries of others" if message.others else ""
    console.print(f"context {describe_context(message.context)}{others}", highlight=False)
    phase = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    mean, std = feedforward.mean(phase), feedforward.std(phase)
    for axis, name in enumerate(feedforward.axes):
        for p, m, s in zip(phase, mean[axis], std[axis], strict=True):
            console.print(
                f"  {name}  phase {p:5.3f} rad  {m:9.5f} ± {s:.5f} {unit_of_axis(name)}/s²"
            )
