"""A frame task that leaves and comes back, over 0.2 s and at once: how much torques jump.

Run: python -m benchmarks.ramped_task [--robots NAME|FILE ...] [--seeds N] [--json FILE]
    [--figure FILE]

The robot stands, its model 10 % wrong, and its posture asks for joint angles away from
home, so that the task and what takes over from it disagree. Each of its frame tasks in
turn leaves after a second and is back two seconds later. What counts is the largest
change of a torque from one tick to the next, as a share of the joint's limit, while the
task is on its way.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.controller.controller import Controller
from tsd_casadi.robot.robot import Robot, load_robot
from tsd_casadi.robot.robot_file_tasks import FrameTaskFile
from tsd_casadi.state import Matrix, Vector
from tsd_clients.console.progress import show_progress
from tsd_clients.console.table import Column, console, print_table
from tsd_clients.simulator.simulator import MujocoSimulator

ROBOTS = ("hermes_lower", "g1", "talos")
RAMP = 0.2  # s
LARGEST_STEP = 0.02  # of a joint's torque limit
MODEL_ERROR = 0.1
# how far the posture is from home, in all joints [rad]
AWAY = 0.15
SETTLED, OUT, BACK, END = 0.8, 1.0, 3.0, 3.4  # s
FALLEN = 0.6  # of the height of the centre of mass at home


@dataclass(frozen=True)
class Passage:
    """A task that left and came back.

    Attributes:
        times: Of the ticks since it settled, (N,) [s].
        torques: As shares of the joints' limits, (N, n).
        fell: Whether the robot did.
        failed: Ticks without a solution.
    """

    times: Vector
    torques: Matrix
    fell: bool
    failed: int

    @property
    def steps(self) -> Vector:
        """Largest change of each joint's torque from tick to tick, (n,), share of its limit."""
        return np.asarray(np.abs(np.diff(self.torques, axis=0)).max(axis=0))


def level_at(time: float, ramp: float) -> float:
    """Tell how much the task counts.

    Args:
        time: [s].
        ramp: Over how long it leaves and comes [s]; 0 is at once.
    """
    return float(np.interp(time, [OUT, OUT + ramp, BACK, BACK + ramp], [1.0, 0.0, 0.0, 1.0]))


def pass_through(
    robot: Robot, controller: Controller, task: str, ramp: float, seed: int
) -> Passage:
    """Simulate a task that leaves and comes back."""
    simulator = MujocoSimulator(robot, MODEL_ERROR)
    body, command = simulator.body(robot.home, robot.home, seed), controller.command()
    command["period"] = period = simulator.period
    away = np.random.default_rng(seed).uniform(-AWAY, AWAY, robot.n)
    times, torques, failed = [], [], 0
    for index in range(round(END / period)):
        time = index * period
        _, measured = body.measure()
        if body.com[2] < FALLEN * robot.home_com[2]:
            return Passage(np.array(times), np.array(torques), True, failed)
        command[f"{task}.active"] = level_at(time, ramp)
        # slowly, so that this is over before the task leaves
        command["posture.q_ref"] = robot.home.q[7:] + min(1.0, time / SETTLED) * away
        tick = controller.tick(measured, command)
        failed += tick.status != 0
        if time >= SETTLED:
            times.append(time)
            torques.append(tick.tau / robot.torque_limit)
        body.step(tick.tau, time)
    return Passage(np.array(times), np.array(torques), False, failed)


def frame_tasks(robot: Robot) -> list[str]:
    """Name the robot's frame tasks."""
    return [task.name for task in robot.description.tasks if isinstance(task, FrameTaskFile)]


def compare(robot: Robot, controller: Controller, task: str, seed: int) -> dict[str, Any]:
    """Measure one task both ways."""
    found: dict[str, Any] = {"robot": robot.name, "task": task, "seed": seed}
    for name, ramp in (("ramp", RAMP), ("switch", 0.0)):
        passage = pass_through(robot, controller, task, ramp, seed)
        worst = int(np.argmax(passage.steps))
        found[name] = {
            "largest_step": float(passage.steps[worst]),
            "joint": robot.joint_names[worst],
            "fell": passage.fell,
            "failed": passage.failed,
        }
    return found


def meets_the_goal(result: dict[str, Any]) -> bool:
    """Tell whether a ramp was smooth enough, without a fall and with every tick solved."""
    ramp = result["ramp"]
    return bool(ramp["largest_step"] <= LARGEST_STEP and not ramp["fell"] and not ramp["failed"])


def draw(robot: Robot, controller: Controller, task: str, seed: int, path: Path) -> None:
    """Draw the torque that jumps most, both ways."""
    from matplotlib.figure import Figure

    switched = pass_through(robot, controller, task, 0.0, seed)
    ramped = pass_through(robot, controller, task, RAMP, seed)
    joint = int(np.argmax(switched.steps))
    figure = Figure(figsize=(8, 5), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(1, 2))
    for passage, ramp, color, words in (
        (switched, 0.0, "#c8352b", "at once"),
        (ramped, RAMP, "#3b6fb6", f"over {RAMP:g} s"),
    ):
        levels = [level_at(time, ramp) for time in passage.times]
        above.plot(passage.times, levels, color=color, label=words)
        below.plot(passage.times, 100 * passage.torques[:, joint], color=color)
    above.set(ylabel=f"{task}.active", title=f"{robot.name}: the task '{task}' leaves and comes")
    above.legend(frameon=False)
    below.set(xlabel="time [s]", ylabel=f"{robot.joint_names[joint]}, % of its torque limit")
    figure.savefig(path, dpi=110)


def show(results: list[dict[str, Any]]) -> None:
    """Print the worst of each task, both ways."""
    worst: dict[tuple[str, str], dict[str, Any]] = {}
    for result in results:
        key = result["robot"], result["task"]
        if key not in worst or _step(result) > _step(worst[key]):
            worst[key] = result
    rows = list(worst.values())

    def percent(name: str) -> list[str]:
        return [f"{100 * row[name]['largest_step']:.3f}" for row in rows]

    columns = [
        Column("robot", [row["robot"] for row in rows], is_text=True),
        Column("task", [row["task"] for row in rows], is_text=True),
        Column(f"over {RAMP:g} s, %\n<= {100 * LARGEST_STEP:g}", percent("ramp")),
        Column("joint", [row["ramp"]["joint"] for row in rows], is_text=True, rank=1),
        Column("at once, %", percent("switch")),
        Column("joint", [row["switch"]["joint"] for row in rows], is_text=True, rank=2),
    ]
    print_table("largest change of a torque per tick, of the joint's limit", columns)
    fallen = sum(result["ramp"]["fell"] for result in results)
    failed = sum(result["ramp"]["failed"] for result in results)
    met = sum(map(meets_the_goal, results))
    console.print(
        f"over {RAMP:g} s: {met} of {len(results)} meet the goal, {fallen} fell, "
        f"{failed} ticks without a solution"
    )


def _step(result: dict[str, Any]) -> float:
    return float(result["ramp"]["largest_step"])


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--robots", nargs="+", default=ROBOTS, help="names or robot files")
    parser.add_argument("--seeds", type=int, default=3, help="postures of each robot and task")
    parser.add_argument("--json", type=Path, help="write the numbers to this file")
    parser.add_argument("--figure", type=Path, help="draw the first robot's last task here")
    arguments = parser.parse_args()
    results: list[dict[str, Any]] = []
    for name in arguments.robots:
        robot = load_robot(name)
        controller, tasks = compile_controller(robot), frame_tasks(robot)
        with show_progress(robot.name, float(len(tasks) * arguments.seeds)) as report:
            for task in tasks:
                for seed in range(arguments.seeds):
                    results.append(compare(robot, controller, task, seed))
                    report(float(len(results)), float(len(tasks) * arguments.seeds))
        if arguments.figure and name == arguments.robots[0]:
            draw(robot, controller, tasks[-1], 0, arguments.figure)
    show(results)
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=2))


if __name__ == "__main__":
    main()
