"""Why a tick of a log had no solution, for the command line."""

from __future__ import annotations

from pathlib import Path

import typer

from tsd_casadi.explanation.explain import explain
from tsd_casadi.formulation.inverse_dynamics import InverseDynamics
from tsd_casadi.repetition.tick_log import NO_STATUS
from tsd_casadi.robot.robot import load_robot
from tsd_casadi.tick.format import Status
from tsd_cli.interrupt import interruptible
from tsd_cli.options.output import JsonOptions
from tsd_cli.options.robot import RobotOptions
from tsd_cli.output import STDOUT, check_outputs, put_out
from tsd_clients.console.explanation_tables import print_explanation
from tsd_clients.logs.logged_request import first_tick, logged_request
from tsd_clients.logs.read_log import read_log


@interruptible()
def explain_tick(path: Path, tick: int | None, robot: str | None, output: JsonOptions) -> None:
    """Explain a tick and show what was found.

    Raises:
        TsdError: If the log cannot be used, or has no such tick.
    """
    check_outputs(output)
    log = read_log(path)
    problem = InverseDynamics(load_robot(robot or log.robot or RobotOptions().robot))
    number = first_tick(log) if tick is None else tick
    request, rests_on = logged_request(log, number, problem)
    explanation = explain(problem, request)
    status = int(log.fields["status"][number])
    told = "missed" if status == NO_STATUS else Status(status).name.lower()
    notes = [f"from {each}" for each in rests_on]
    if explanation.feasible and status == Status.INFEASIBLE:
        notes.append("infeasible then, feasible as put together here: see what it rests upon")
    result = {
        "robot": problem.robot.name,
        "tick": number,
        "time": float(log.fields["time"][number]),
        "status": told,
        "notes": notes,
        **explanation.plain(),
    }
    title = f"tick {number} at {result['time']:.3f} s, {told}"
    put_out(result, output, lambda: print_explanation(title, result))
    if output.json_file != STDOUT:
        for note in notes:
            typer.echo(note)
