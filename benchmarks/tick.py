"""What one control tick costs, and where the time goes.

Run: python -m benchmarks.tick [--robot NAME|FILE] [--states N] [--json FILE]

The compiled tick and the same QP from numeric Pinocchio, numpy and DAQP (called
from Python) take turns on the same requests: 'nominal' ones along a squat with
a 10 % wrong model, where hardly any limit is active, and 'stressed' ones with
torque limits at a quarter, low friction and random motion. Needs the extra
'benchmark' (daqp).
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from rich import box
from rich.table import Table
from threadpoolctl import threadpool_limits

from benchmarks.numeric_controller import NumericController
from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.controller.controller import Controller
from tsd_casadi.formulation.inverse_dynamics import InverseDynamics
from tsd_casadi.motions.squat import Squat
from tsd_casadi.robot.robot import load_robot
from tsd_casadi.state import State, Vector
from tsd_clients.console.progress import show_progress
from tsd_clients.console.table import console
from tsd_clients.simulator.simulator import MujocoSimulator

PHASES = ("data", "factorisation", "solve")


def nominal_requests(controller: Controller, robot: Any, count: int) -> list[Vector]:
    """Collect requests along a simulated squat of 3 cm at 0.25 Hz."""
    squat = Squat(0.03, 0.25)
    run = MujocoSimulator(robot, 0.1).run(controller, squat, axes=squat.axes(robot), laps=2)
    command = controller.command()
    com = squat.axes(robot)[0].split(".")[0]
    requests = []
    for tick in np.linspace(2000, run.ticks - 1, count).astype(int):
        command[f"{com}.reference"][2] = robot.home_com[2] + run.log["reference"][tick, 0]
        q = run.log["q"][tick].astype(float)
        q[3:7] /= np.linalg.norm(q[3:7])
        command.set_state(State(q, run.log["v"][tick].astype(float)))
        requests.append(command.request.copy())
    return requests


def stressed_requests(controller: Controller, robot: Any, count: int) -> list[Vector]:
    """Draw requests with several active limits, unrelated to each other."""
    rng = np.random.default_rng(0)
    com = Squat(0.03, 0.25).axes(robot)[0].split(".")[0]
    requests: list[Vector] = []
    while len(requests) < count:
        command = controller.command()
        command["limits.torque"] *= 0.25
        command["limits.acceleration"] = 60.0
        for contact in robot.description.contacts:
            command[f"{contact.name}.friction"] = 0.3
        command[f"{com}.reference"] += rng.normal(0, 0.03, 3)
        q, v = robot.home.q.copy(), rng.normal(0, 0.2, robot.nv)
        q[7:] += rng.normal(0, 0.05, robot.n)
        tick = controller.tick(State(q, v), command)
        if tick.status == 0 and len(tick.active) >= 3:
            requests.append(command.request.copy())
    return requests


def measure(
    controller: Controller, numeric: NumericController, requests: list[Vector], report: Any
) -> dict[str, Any]:
    """Let both take turns, in blocks of 50 requests, over three rounds.

    Returns:
        Times [us] of both by phase, the ratio of medians, the largest
        difference in torque [N m] and the mean number of active limits.
    """
    compiled_times, numeric_times = [], []
    difference, active = 0.0, []
    tau = controller.format.reply.slice("tau")
    rows = controller.format.reply.slice("active")
    for round_ in range(3):
        for start in range(0, len(requests), 50):
            block = requests[start : start + 50]
            replies = [controller.run(request) for request in block]
            ticks = [numeric.tick(request) for request in block]
            compiled_times += [reply[2:5] for reply in replies]
            numeric_times += [tick.times for tick in ticks]
            for reply, tick in zip(replies, ticks, strict=True):
                difference = max(difference, float(np.abs(reply[tau] - tick.tau).max()))
                active.append(int(np.sum(np.abs(reply[rows]) == 1)))
            report(round_ + (start + 50) / len(requests), 3)
    compiled, by_hand = summarize(np.array(compiled_times)), summarize(np.array(numeric_times))
    return {
        "compiled": compiled,
        "numeric": by_hand,
        "ratio_p50": by_hand["total"]["p50"] / compiled["total"]["p50"],
        "largest_torque_difference": difference,
        "mean_active_limits": float(np.mean(active)),
        "states": len(requests),
    }


def summarize(times: Any) -> dict[str, dict[str, float]]:
    """Compute median and 99th percentile by phase and in total."""
    columns = {**dict(zip(PHASES, times.T, strict=True)), "total": times.sum(axis=1)}
    return {
        name: {"p50": float(np.percentile(column, 50)), "p99": float(np.percentile(column, 99))}
        for name, column in columns.items()
    }


def print_results(results: dict[str, Any]) -> None:
    """Print one table for all sets of requests."""
    table = Table(title="one tick [µs], p50 (p99)", title_justify="left", box=box.SIMPLE_HEAD)
    table.add_column("requests")
    table.add_column("implementation")
    for heading in (*PHASES, "total"):
        table.add_column(heading, justify="right")
    for name, result in results.items():
        for implementation in ("compiled", "numeric"):
            cells = [
                f"{result[implementation][phase]['p50']:.1f} "
                f"({result[implementation][phase]['p99']:.0f})"
                for phase in (*PHASES, "total")
            ]
            table.add_row(name, implementation, *cells)
    console.print(table)
    for name, result in results.items():
        console.print(
            f"{name}: compiled is {result['ratio_p50']:.1f} times faster at the median, "
            f"{result['mean_active_limits']:.1f} active limits on average, torques agree to "
            f"{result['largest_torque_difference']:.1e} N m"
        )


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--robot", default="hermes_lower", help="name or robot file")
    parser.add_argument("--states", type=int, default=500, help="requests of each kind")
    parser.add_argument("--json", type=Path, help="write the numbers to this file")
    arguments = parser.parse_args()
    robot = load_robot(arguments.robot)
    controller = compile_controller(robot)
    numeric = NumericController(InverseDynamics(robot))
    results = {}
    for name, make in (("nominal", nominal_requests), ("stressed", stressed_requests)):
        requests = make(controller, robot, arguments.states)
        # BLAS threads cost more than they give at these sizes
        with threadpool_limits(1), show_progress(name, 3.0) as report:
            results[name] = measure(controller, numeric, requests, report)
    print_results(results)
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=2))


if __name__ == "__main__":
    main()
