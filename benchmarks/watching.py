"""What it costs a tick that a run is logged and watched.

Run: python -m benchmarks.watching [--robot NAME|FILE] [--alternations N] [--periods N] [--pace F]

Squats against the clock, one tick a millisecond, with a controller service of their own:
with nobody watching; logged as MCAP and watched by a process that reads; watched by one
that was stopped and never reads. They take turns. What is compared is the round trip of
a tick, and the whole work of a period from the measurement until the torque is applied.
"""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

import numpy as np

from tsd_casadi.encoding.laps import Lap
from tsd_casadi.motions.squat import Squat
from tsd_casadi.repetition.compensator import Moment, Setting
from tsd_casadi.repetition.observer import Observer
from tsd_casadi.repetition.pace import Pace
from tsd_casadi.repetition.run import Run
from tsd_casadi.robot.robot import load_robot
from tsd_casadi.state import State, Vector
from tsd_clients.logs.mcap_log import McapLog
from tsd_clients.remote.remote_controller import RemoteController
from tsd_clients.simulator.simulator import MujocoSimulator
from tsd_clients.telemetry.telemetry import Telemetry
from tsd_server.service_process import ServiceProcess, free_endpoint

OFF, ON, FROZEN = "nobody", "logged and watched", "watched, never read"
GOALS = {"p50": 1.05, "p99": 1.3}


class Enough(Exception):
    """All periods that were asked for are over."""


class TimedSimulator(MujocoSimulator):
    """A simulated robot that notes how long each period's work takes.

    Attributes:
        work: From the measurement until the torque is applied [us].
        periods: After so many of them it ends the repetition: whether that is steady
            does not matter, and where cores are taken it never is.
    """

    def __init__(self, robot: str) -> None:
        """Simulate a robot whose model is 10 % wrong."""
        super().__init__(load_robot(robot), 0.1)
        self.work: list[float] = []
        self.periods = 0

    def measure(self) -> State:
        """Measure, and begin to count."""
        self._began = perf_counter()
        return super().measure()

    def apply(self, tau: Vector) -> None:
        """Go on by one period, and note how long all of it took."""
        super().apply(tau)
        self.work.append(1e6 * (perf_counter() - self._began))
        if len(self.work) == self.periods:
            raise Enough


class Audience:
    """Somebody in another process who watches from before the first tick to the end."""

    def __init__(self, *, reads: bool) -> None:
        """Watch, or be stopped after having subscribed."""
        self._reads = reads

    def start(self, setting: Setting) -> None:
        """Come, and sit down before it begins."""
        self._process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.watcher", str(os.getpid())],
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout is not None
        if self._process.stdout.readline() != "watching\n":
            raise RuntimeError("the run cannot be watched")
        if not self._reads:
            self._process.send_signal(signal.SIGSTOP)
            os.waitid(os.P_PID, self._process.pid, os.WSTOPPED)

    def tick(self, moment: Moment) -> None:
        """Sit still."""

    def missed(self, moment: Moment) -> None:
        """Sit still."""

    def lap(self, lap: Lap) -> None:
        """Sit still."""

    def end(self, outcome: str) -> None:
        """Go."""
        self._process.kill()
        self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()


@dataclass
class Times:
    """What was measured of one way to be watched.

    Attributes:
        round_trip: Of each tick that was answered [us].
        work: Of each period [us].
        missed: Periods without an answer.
        dropped: Rows that were not published.
    """

    round_trip: list[Vector] = field(default_factory=list)
    work: list[Vector] = field(default_factory=list)
    missed: int = 0
    dropped: int = 0


def measure(
    robot: str, alternations: int, periods: int, pace: float, folder: Path
) -> dict[str, Times]:
    """Let the three ways take turns.

    Args:
        periods: Of each run.
        pace: 1 for a tick each millisecond.
        folder: For logs.
    """
    times = {name: Times() for name in (OFF, ON, FROZEN)}
    simulator = TimedSimulator(robot)
    simulator.periods = periods
    endpoint = free_endpoint()
    with (
        ServiceProcess(["controller", "--robot", robot, "--listen", endpoint]),
        RemoteController(simulator.robot.name, [endpoint]) as controller,
    ):
        for turn in range(alternations):
            for name in (OFF, ON, FROZEN) if turn % 2 else (FROZEN, ON, OFF):
                kept = times[name]
                simulator.work = []
                observers: list[Observer] = []
                telemetry = log = None
                if name != OFF:
                    telemetry = Telemetry(simulator.robot.name)
                    observers += [telemetry, Audience(reads=name == ON)]
                if name == ON:
                    log = McapLog(folder / f"{turn}.mcap")
                    observers.append(log)
                runs: list[Run] = []
                with suppress(Enough):
                    simulator.run(
                        controller,
                        Squat(0.03, 1.0),
                        laps=periods,
                        observers=observers,
                        pace=Pace(pace, 10.0),
                        on_abort=runs.append,
                    )
                (run,) = runs
                if log is not None:
                    log.conclude(run)
                if telemetry is not None:
                    telemetry.close()
                    kept.dropped += telemetry.dropped
                answered = run.log["missed"] == 0
                kept.round_trip.append(run.log["tick_us"][answered])
                kept.work.append(np.array(simulator.work))
                kept.missed += int((~answered).sum())
    return times


def tell(times: dict[str, Times]) -> None:
    """Print quantiles, and their ratios alternation by alternation."""
    for what in ("round_trip", "work"):
        print(f"{what.replace('_', ' ')} [us]")
        nobody = np.array([_quantiles(each) for each in getattr(times[OFF], what)])
        for name, each in times.items():
            found = np.array([_quantiles(values) for values in getattr(each, what)])
            ratios = found / nobody
            words = ", ".join(
                f"{label} {np.median(found[:, place]):6.0f} ({np.median(ratios[:, place]):.2f} "
                f"times, {ratios[:, place].min():.2f} to {ratios[:, place].max():.2f})"
                for place, label in enumerate(GOALS)
            )
            print(f"  {name:20s} {words}")
    for name, each in times.items():
        periods = sum(map(len, each.work))
        print(f"{name:20s} {each.missed} of {periods} periods missed, {each.dropped} rows dropped")
    print(f"goals: {', '.join(f'{name} <= {goal} times' for name, goal in GOALS.items())}")


def _quantiles(values: Vector) -> list[float]:
    return [float(np.percentile(values, 50)), float(np.percentile(values, 99))]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="hermes_lower")
    parser.add_argument("--alternations", type=int, default=5)
    parser.add_argument("--periods", type=int, default=5000)
    parser.add_argument("--pace", type=float, default=1.0, help="less where cores are taken")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["TSD_RUN_DIR"] = str(Path(folder) / "run")
        times = measure(
            arguments.robot,
            arguments.alternations,
            arguments.periods,
            arguments.pace,
            Path(folder),
        )
    tell(times)
    print(f"load of the machine, 1 min: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")


if __name__ == "__main__":
    main()
