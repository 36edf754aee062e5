"""'tsd query' and 'tsd database': what the learner knows."""

from __future__ import annotations

import json
from typing import Annotated

import numpy as np
import typer

from tsd_casadi.robot.robot import load_robot
from tsd_casadi.wire.endpoints import LEARNER
from tsd_casadi.wire.feedforward import FeedforwardMessage
from tsd_cli.commands.options import (
    ROBOT,
    ConnectOption,
    FrequencyOption,
    HeightOption,
    JsonOption,
    MotionArgument,
    RobotOption,
    make_motion,
)
from tsd_cli.commands.output import check_writable, put_out
from tsd_clients.console.tables import console, describe_parameters, describe_values, print_entries
from tsd_clients.remote.remote_learner import RemoteLearner


def query(
    motion: MotionArgument,
    amplitude: Annotated[
        float, typer.Option("--amplitude", help="Half of peak to peak, in metres.")
    ],
    frequency: FrequencyOption = 0.25,
    height: HeightOption = 0.0,
    robot: RobotOption = ROBOT,
    kind: Annotated[
        str | None,
        typer.Option("--kind", help="learned or generalised; default: learned where it exists."),
    ] = None,
    extrapolate: Annotated[
        bool, typer.Option("--extrapolate", help="Answer outside the learned range too.")
    ] = False,
    connect: ConnectOption = None,
    json_file: JsonOption = None,
) -> None:
    """Ask the learner what to feed forward."""
    check_writable(json_file)
    loaded = load_robot(robot)
    wanted = make_motion(motion, amplitude, frequency, height)
    wanted.check(loaded)
    with RemoteLearner(connect or [LEARNER]) as remote:
        message = remote.query_message(
            motion, robot=loaded.name, kind=kind, extrapolate=extrapolate, **wanted.parameters
        )
    plain = json.loads(message.encode())
    put_out(plain, json_file, lambda: _print_feedforward(message))


def list_entries(connect: ConnectOption = None, json_file: JsonOption = None) -> None:
    """List what was learned."""
    check_writable(json_file)
    with RemoteLearner(connect or [LEARNER]) as remote:
        reply = remote.database()
    put_out(reply.model_dump(mode="json"), json_file, lambda: print_entries(reply))


def forget_entry(
    entry: Annotated[int, typer.Argument(help="Number of the entry, from 'tsd database list'.")],
    connect: ConnectOption = None,
) -> None:
    """Remove one entry with all its iterations."""
    with RemoteLearner(connect or [LEARNER]) as remote:
        reply = remote.forget(entry)
    if reply.forgotten is not None:
        forgotten = reply.forgotten
        typer.echo(
            f"forgot entry {forgotten.entry}: {forgotten.task} of {forgotten.robot}, "
            f"{describe_parameters(forgotten)}"
        )


def _print_feedforward(message: FeedforwardMessage) -> None:
    feedforward = message.feedforward()
    parameters = describe_values(message.task, feedforward.parameters)
    console.print(f"{feedforward.kind} feedforward for {parameters}, axes {feedforward.axes}")
    source = "entries {entries}, iteration {iteration}".format(**feedforward.provenance)
    console.print(f"from {source}; the whole answer: --json -")
    phase = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    mean, std = feedforward.mean(phase), feedforward.std(phase)
    for axis, name in enumerate(feedforward.axes):
        for p, m, s in zip(phase, mean[axis], std[axis], strict=True):
            console.print(f"  {name}  phase {p:5.3f} rad  {m:9.5f} ± {s:.5f} m/s²")
