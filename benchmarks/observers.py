"""What watching a repetition costs a tick.

Run: python -m benchmarks.observers [--robot NAME|FILE] [--repetitions N]

Repetitions of a squat without anybody watching, with a viewer that never takes
what it is given (it drops the oldest ticks), with another recorder of every
tick, and published for other processes take turns. Time is the processor's in this
process, of whole repetitions with simulation and controller, by tick.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from time import process_time

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.observer import Glimpses, Observer
from tsd_casadi.repetition.tick_log import TickLog
from tsd_casadi.robot.robot import load_robot
from tsd_clients.simulator.simulator import MujocoSimulator
from tsd_clients.telemetry.telemetry import Telemetry

WATCHING: dict[str, Callable[[], list[Observer]]] = {
    "nobody": list,
    "viewer, dropping": lambda: [Glimpses(100)],
    "recorder": lambda: [TickLog()],
    "both": lambda: [Glimpses(100), TickLog()],
    "published": lambda: [Telemetry("robot")],
}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="hermes_lower")
    parser.add_argument("--repetitions", type=int, default=10)
    arguments = parser.parse_args()
    robot = load_robot(arguments.robot)
    controller, simulator = compile_controller(robot), MujocoSimulator(robot, 0.1)
    times: dict[str, list[float]] = {name: [] for name in WATCHING}
    for _ in range(arguments.repetitions):
        for name, observers in WATCHING.items():
            watching = observers()
            before = process_time()
            run = simulator.run(controller, Squat(0.03, 1.0), laps=2, observers=watching)
            times[name].append(1e6 * (process_time() - before) / run.ticks)
            for each in watching:
                if isinstance(each, Telemetry):
                    each.close()
    for name, each in times.items():
        each.sort()
        print(f"{name:18s} {each[0]:6.1f} us a tick at best, {each[len(each) // 2]:6.1f} usually")


if __name__ == "__main__":
    main()
