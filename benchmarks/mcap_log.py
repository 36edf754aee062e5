"""What a log as MCAP costs: a tick of the loop, the process that writes it, the disk.

Run: python -m benchmarks.mcap_log [--robot NAME|FILE] [--alternations N] [--laps N]

Squats paced at 1 kHz by turns without and with a log. Printed are what the log's
observer takes of a tick, ticks without and with it, what share of a core the process
that writes takes once it has started, and how fast the file grows.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np

from tsd_casadi.compilation.compile_controller import compile_controller
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.compensator import Moment
from tsd_casadi.repetition.pace import Pace
from tsd_casadi.robot.robot import load_robot
from tsd_clients.logs.mcap_log import McapLog
from tsd_clients.simulator.simulator import MujocoSimulator


class TimedLog(McapLog):
    """Notes what each tick takes.

    Attributes:
        times: [us].
    """

    def __init__(self, path: Path) -> None:
        """Start with nothing."""
        super().__init__(path)
        self.times: list[float] = []

    def tick(self, moment: Moment) -> None:
        """Note a tick and its time."""
        before = perf_counter()
        super().tick(moment)
        self.times.append(1e6 * (perf_counter() - before))


def quantiles(times: list[float]) -> str:
    """Write p50 and p99."""
    p50, p99 = np.percentile(times, (50, 99))
    return f"p50 {p50:6.1f} us, p99 {p99:6.1f} us"


def children() -> float:
    """Tell the processor time of the processes that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="hermes_lower")
    parser.add_argument("--alternations", type=int, default=5)
    parser.add_argument("--laps", type=int, default=8)
    arguments = parser.parse_args()
    robot = load_robot(arguments.robot)
    controller, simulator = compile_controller(robot), MujocoSimulator(robot, 0.1)
    observed: list[float] = []
    ticks: dict[str, list[float]] = {"without": [], "with": []}
    busy, size, seconds = [], 0, 0.0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(arguments.alternations):
            for kind, measured in ticks.items():
                logs = [TimedLog(Path(folder) / f"{number}.mcap")] if kind == "with" else []
                before = children()
                run = simulator.run(
                    controller,
                    Squat(0.03, 1.0),
                    laps=arguments.laps,
                    observers=logs,
                    pace=Pace(1.0),
                )
                measured += run.log["tick_us"].tolist()
                for log in logs:
                    log.conclude(run)
                    observed += log.times
                    busy.append(children() - before)
                    size += log.path.stat().st_size
                    seconds += run.ticks * run.settings["period_s"]
    print(f"observer: {quantiles(observed)} of a tick")
    for kind, measured in ticks.items():
        print(f"ticks {kind:8s}: {quantiles(measured)}")
    print(f"writer: {100 * sum(busy) / seconds:.0f} % of a core, its start included")
    print(f"file: {60e-6 * size / seconds:.0f} MB a minute, {size / len(observed):.0f} B a tick")


if __name__ == "__main__":
    main()
