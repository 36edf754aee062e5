"""Whether joints keep their limits of position and velocity, and what that costs.

Run: python -m benchmarks.limits [--robots NAME|FILE ...] [--seconds S] [--states N] [--json FILE]

'runs': simulated at 1 kHz, the references wander at random and the posture asks for
angles beyond the limits. 'states': the accelerations of random states, against the
state that they lead to a period later, predicted in both ways. 'tick': time with the
limits and without, in turns on the same requests.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.tick import nominal_requests
from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.constraints.joint_position import MARGIN
from tsd_casadi.controller.controller import Controller
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_casadi.state import State, Vector
from tsd_casadi.tick.row_state import AT_LIMIT, RowState
from tsd_clients.console.progress import show_progress
from tsd_clients.console.table import Column, console, print_table
from tsd_clients.simulator.simulator import MujocoSimulator

ROBOTS = ("hermes_lower", "g1", "talos")
# largest of a run [rad, rad/s], where the reply said so; of a state, with its rounding
BEYOND_POSITION, BEYOND_VELOCITY, BEYOND_ROW = 1e-3, 1e-2, 1e-6
COST = 1.15
FALLEN = 0.6  # of the height of the centre of mass at home


class Wandering:
    """References that go from one random place to the next every second."""

    def __init__(self, robot: Robot, seed: int) -> None:
        """Draw where it all goes."""
        self._rng = np.random.default_rng(seed)
        low, high = robot.position_limits
        self._low, self._high = low, high
        self._home, self._com = robot.home.q[7:], robot.home_com
        self._from = self._to = (self._home.copy(), self._com.copy())
        self._second = -1

    def at(self, time: float) -> tuple[Vector, Vector]:
        """Tell joint angles and centre of mass.

        Args:
            time: [s].
        """
        if int(time) != self._second:
            self._second, self._from = int(time), self._to
            # a third of the joints to or beyond one of their limits, the others about home
            wide = self._high - self._low
            anywhere = self._rng.uniform(self._low - 0.3 * wide, self._high + 0.3 * wide)
            far = self._rng.random(self._home.size) < 1 / 3
            # from crouches to straight knees, where the soles of narrow feet stay flat
            share = self._rng.uniform([-0.02, -0.03, -0.15], [0.02, 0.03, 0.25])
            com = self._com + share * self._com[2]
            self._to = (np.where(far, anywhere, self._home), com)
        share = 0.5 - 0.5 * np.cos(np.pi * (time - self._second))
        angles, com = ((1 - share) * a + share * b for a, b in zip(self._from, self._to))  # noqa: B905
        return angles, com


def wander(robot: Robot, controller: Controller, seconds: float, seed: int) -> dict[str, Any]:
    """Simulate, and measure how far beyond limits joints are."""
    simulator = MujocoSimulator(robot)
    body = simulator.body(robot.home, robot.home, seed)
    wandering, command = Wandering(robot, seed), controller.command()
    com = next(task.name for task in robot.description.tasks if task.type == "com")
    command["period"] = simulator.period
    low, high = robot.position_limits
    joints = slice(*(controller.format.reply.slice("active").start + np.array([6, robot.nv])))
    said = np.zeros(robot.n, dtype=bool)
    worst = {"position": 0.0, "velocity": 0.0, "unsaid position": 0.0, "unsaid velocity": 0.0}
    at_limit, yielded, failed, ticks = 0, 0, 0, round(seconds / simulator.period)
    for tick in range(ticks):
        true, measured = body.measure()
        if body.com[2] < FALLEN * robot.home_com[2]:
            return {**worst, "fell": tick * simulator.period, "failed": failed}
        command["posture.q_ref"], command[f"{com}.reference"] = wandering.at(
            tick * simulator.period
        )
        reply = controller.tick(measured, command)
        state = np.abs(reply.reply[joints])
        now = np.isin(state, AT_LIMIT)
        q, v = true.q[7:], np.abs(true.v[6:])
        position = np.maximum(np.maximum(low - q, q - high), 0.0)
        velocity = np.maximum(v - robot.velocity_limit, 0.0)
        for name, beyond in (("position", position), ("velocity", velocity)):
            worst[name] = max(worst[name], float(beyond.max()))
            silent = beyond[~(said | now)]
            worst[f"unsaid {name}"] = max(worst[f"unsaid {name}"], float(silent.max(initial=0.0)))
        said = now
        at_limit += bool(now.any())
        yielded += bool((state == RowState.YIELDED).any())
        failed += reply.status != 0
        body.step(reply.tau, tick * simulator.period)
    return {
        **worst,
        "fell": None,
        "failed": failed,
        "at_limit": at_limit / ticks,
        "yielded": yielded / ticks,
    }


def random_states(robot: Robot, controller: Controller, count: int) -> dict[str, Any]:
    """Draw states inside the limits, and look one period ahead."""
    rng, command = np.random.default_rng(0), controller.command()
    low, high = robot.position_limits
    period, braking = command["period"][0], command["limits.braking"]
    fastest = np.minimum(robot.velocity_limit, 10.0)
    joints = slice(*(controller.format.reply.slice("active").start + np.array([6, robot.nv])))
    worst, yielded, failed, infeasible, at_limit = 0.0, 0, 0, 0, 0
    free = controller.command()
    for _ in range(count):
        q, v = robot.home.q.copy(), np.zeros(robot.nv)
        anywhere = rng.uniform(low, high)
        # every other joint near a limit
        margin = MARGIN * braking * period**2
        way = margin + rng.exponential(0.01, robot.n)
        near = np.clip(np.where(rng.random(robot.n) < 0.5, low + way, high - way), low, high)
        moved = rng.random(robot.n)
        q[7:] = np.where(moved < 0.2, anywhere, np.where(moved < 0.5, near, q[7:]))
        # no faster than it can stop, which the limits would have seen to before
        room = np.minimum(high - q[7:], q[7:] - low) - margin
        can_stop = np.sqrt(2 * braking * np.maximum(room, 0.0))
        v[6:] = rng.uniform(-1, 1, robot.n) * np.minimum(fastest, can_stop) * rng.random()
        tick = controller.tick(State(q, v), command)
        if tick.status != 0:
            free.request[:] = command.request
            free["limits.position_active"] = free["limits.velocity_active"] = 0.0
            failed += controller.tick(State(q, v), free).status == 0
            infeasible += 1
            continue
        state = np.abs(tick.reply[joints])
        holds = state != RowState.YIELDED
        v_next = v[6:] + period * tick.qdd[6:]
        position = [q[7:] + period * v_next, q[7:] + period * (v[6:] + v_next) / 2]
        beyond = [np.maximum(low - each, each - high) for each in position]
        beyond.append(np.abs(v_next) - robot.velocity_limit)
        worst = max(worst, *(float(each[holds].max(initial=0.0)) for each in beyond))
        yielded += not holds.all()
        at_limit += bool(np.isin(state, AT_LIMIT).any())
    return {
        "beyond": worst,
        "yielded": yielded,
        "failed only with the limits": failed,
        "infeasible without them": infeasible - failed,
        "at_limit": at_limit,
    }


def tick_cost(robot: Robot, controller: Controller, count: int) -> dict[str, float]:
    """Time ticks with the limits and without, turn by turn."""
    requests = nominal_requests(controller, robot, count)
    without = [request.copy() for request in requests]
    slices = controller.format.request.slices
    for request in without:
        request[slices["limits.position_active"]] = 0.0
        request[slices["limits.velocity_active"]] = 0.0
    times: dict[str, list[float]] = {"with": [], "without": []}
    for _ in range(5):
        for on, off in zip(requests, without, strict=True):
            for name, request in (("with", on), ("without", off)):
                times[name].append(float(controller.run(request)[2:5].sum()))
    p50 = {name: float(np.median(values)) for name, values in times.items()}
    return {**p50, "ratio": p50["with"] / p50["without"]}


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--robots", nargs="+", default=ROBOTS, help="names or robot files")
    parser.add_argument("--seconds", type=float, default=10.0, help="of a run")
    parser.add_argument("--seeds", type=int, default=3, help="runs of each robot")
    parser.add_argument("--states", type=int, default=10_000, help="random states of each robot")
    parser.add_argument("--json", type=Path, help="write the numbers to this file")
    arguments = parser.parse_args()
    results: dict[str, Any] = {}
    for name in arguments.robots:
        robot = load_robot(name)
        controller = compile_controller(robot)
        with show_progress(robot.name, arguments.seeds + 2.0) as report:
            runs = []
            for seed in range(arguments.seeds):
                runs.append(wander(robot, controller, arguments.seconds, seed))
                report(seed + 1.0, arguments.seeds + 2.0)
            states = random_states(robot, controller, arguments.states)
            report(arguments.seeds + 1.0, arguments.seeds + 2.0)
            results[robot.name] = {
                "runs": runs,
                "states": states,
                "tick": tick_cost(robot, controller, 300),
            }
    show(results)
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=2))


def show(results: dict[str, Any]) -> None:
    """Print a table of goals, and the rest below it."""

    def worst(name: str) -> list[str]:
        found = [max(run[name] for run in result["runs"]) for result in results.values()]
        return [f"{value:.1e}" for value in found]

    columns = [
        Column("robot", list(results), is_text=True),
        Column(f"q beyond\n<= {BEYOND_POSITION:g} rad", worst("position")),
        Column("unsaid\n0", worst("unsaid position")),
        Column(f"v beyond\n<= {BEYOND_VELOCITY:g} rad/s", worst("velocity")),
        Column("unsaid\n0", worst("unsaid velocity")),
        Column(
            f"states\n<= {BEYOND_ROW:g}",
            [f"{each['states']['beyond']:.1e}" for each in results.values()],
        ),
        Column(f"tick\n<= {COST:g}", [f"{each['tick']['ratio']:.3f}" for each in results.values()]),
    ]
    print_table("limits of joint position and velocity", columns)
    for name, result in results.items():
        for run in result["runs"]:
            console.print(f"{name} run: {run}")
        console.print(f"{name} states: {result['states']}; tick [us]: {result['tick']}")


if __name__ == "__main__":
    main()
