"""A paced run of the command line whose controller or link is disturbed again and again."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from benchmarks.link import Link
from tsd_casadi.robot.robot import load_robot
from tsd_casadi.tick.missed import Cause
from tsd_server.service_process import free_endpoint

READY = 60.0  # s, for a service or a run to begin
CALM = (1.0, 3.0)  # s between two disturbances
AWAY = (0.2, 3.0)  # s of one
DELAY = (0.02, 0.2)  # s of a slow link; more than a period
# of the blend, at the most, and nothing more
BLENDING = 40


@dataclass
class Outcome:
    """What came of it.

    Attributes:
        kind: Of the disturbances.
        times: How many there were.
        fell: Whether the robot fell.
        periods: All of them.
        missed: Those without an answer, by cause.
        uncounted: Rows without an answer in the log, less those that the summary counts.
        away: How long controller or link were away in all [periods].
        gaps: Stretches of missed periods.
        step: Largest change of a torque in one period from each gap's first period to
            the end of its blend, over the joint's limit.
        cpu: Of each start of the service until it was ready [s].
        exit_code: Of the run, which is ended by Ctrl-C: 130.
    """

    kind: str
    times: int
    fell: bool
    periods: int
    missed: dict[str, int]
    uncounted: int
    away: float
    gaps: int
    step: float
    cpu: list[float] = field(default_factory=list)
    exit_code: int = 0


class Service:
    """A controller as a user starts it."""

    def __init__(self, robot: str, endpoint: str, folder: Path) -> None:
        """Start it and wait until it is ready; in the folder it says that it runs."""
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tsd_cli", "controller", "--robot", robot, "--listen", endpoint],
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "TSD_RUN_DIR": str(folder / "run")},
        )
        assert self.process.stdout is not None
        if " ready on " not in self.process.stdout.readline():
            self.end()
            raise RuntimeError("the controller did not get ready")
        numbers = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        # user and system time, in clock ticks
        self.cpu = (int(numbers[11]) + int(numbers[12])) / os.sysconf("SC_CLK_TCK")

    def end(self) -> None:
        """Kill it."""
        self.process.kill()
        self.process.wait()
        if self.process.stdout is not None:
            self.process.stdout.close()


class DisturbedRun:
    """One paced squat without end, its controller, and the link between them."""

    def __init__(self, folder: Path, robot: str = "hermes_lower", pace: float = 1.0) -> None:
        """Start controller and run, and wait until the robot moves.

        Args:
            folder: For log, summary and what the run prints.
        """
        self._robot, self._folder, self._pace = robot, folder, pace
        self._endpoint = free_endpoint()
        self._service = Service(robot, self._endpoint, folder)
        self.cpu = [self._service.cpu]
        self._link = Link(self._endpoint)
        self._away = 0.0
        self._printed = (folder / "printed").open("w")
        options = (
            f"--frequency 0.5 --laps 100000 --model-error 0.1 --pace {pace} --patience 120 "
            f"--robot {robot} --connect {self._link.endpoint}"
        )
        files = ["--json", str(folder / "run.json"), "--log", str(folder / "run.npz")]
        self._run = subprocess.Popen(
            [sys.executable, "-m", "tsd_cli", "simulate", "squat", *options.split(), *files],
            stdout=self._printed,
            stderr=self._printed,
        )
        time.sleep(3.0 + 1.0 / pace)  # imports, then the hold before the motion

    def __enter__(self) -> DisturbedRun:
        """Use as a context manager."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: object, trace: TracebackType | None
    ) -> None:
        """End what still runs."""
        self._run.kill()
        self._run.wait()
        self._link.__exit__()
        self._service.end()
        self._printed.close()

    def disturb(self, kind: str, times: int, rng: random.Random) -> Outcome:
        """Disturb it, each time after a while, then end it as a user does.

        Args:
            kind: One of ``KINDS``.
        """
        for _ in range(times):
            time.sleep(rng.uniform(*CALM))
            start = time.monotonic()
            KINDS[kind](self, rng)
            self._away += time.monotonic() - start
        time.sleep(CALM[1])
        self._run.send_signal(signal.SIGINT)
        code = self._run.wait(READY)
        return self._outcome(kind, times, code)

    def calm(self, rng: random.Random) -> None:
        """Do nothing: what is late now is late without any disturbance."""

    def kill(self, rng: random.Random) -> None:
        """Kill the controller and start another."""
        self._service.end()
        time.sleep(rng.uniform(0.0, 1.0))
        self._service = Service(self._robot, self._endpoint, self._folder)
        self.cpu.append(self._service.cpu)

    def stop(self, rng: random.Random) -> None:
        """Freeze the controller for a while."""
        self._service.process.send_signal(signal.SIGSTOP)
        time.sleep(rng.uniform(*AWAY))
        self._service.process.send_signal(signal.SIGCONT)

    def cut(self, rng: random.Random) -> None:
        """Cut the link for a while."""
        self._link.cut()
        time.sleep(rng.uniform(*AWAY))
        self._link.mend()

    def silence(self, rng: random.Random) -> None:
        """Let the link pass nothing for a while."""
        self._link.silence()
        time.sleep(rng.uniform(*AWAY))
        self._link.mend()

    def delay(self, rng: random.Random) -> None:
        """Slow the link down for a while."""
        self._link.delay = rng.uniform(*DELAY)
        time.sleep(rng.uniform(*AWAY))
        self._link.mend()

    def _outcome(self, kind: str, times: int, code: int) -> Outcome:
        robot = load_robot(self._robot)
        summary: dict[str, Any] = json.loads((self._folder / "run.json").read_text())
        with np.load(self._folder / "run.npz") as log:
            missed, tau, status = (log[name] for name in ("missed", "tau", "status"))
        steps = np.abs(np.diff(tau, axis=0)) / robot.torque_limit
        without = missed != 0
        # from a period to the next, where one of the last ones had no answer
        near = np.convolve(without, np.ones(BLENDING))[: len(without)] > 0
        counted = Counter(missed[without].tolist())
        return Outcome(
            kind=kind,
            times=times,
            fell=summary["fell"],
            periods=len(missed),
            missed=summary["missed"],
            uncounted=int((status == -1).sum()) - sum(summary["missed"].values())
            if counted == {Cause[_name(words)]: n for words, n in summary["missed"].items()}
            else -1,
            away=1e3 * self._pace * self._away,
            gaps=int((np.diff(without.astype(int)) == 1).sum()),
            step=float(steps[near[1:]].max(initial=0.0)),
            cpu=self.cpu,
            exit_code=code,
        )


def _name(words: str) -> str:
    return words.replace(" ", "_").upper()


KINDS: dict[str, Callable[[DisturbedRun, random.Random], None]] = {
    "calm": DisturbedRun.calm,
    "kill": DisturbedRun.kill,
    "stop": DisturbedRun.stop,
    "cut": DisturbedRun.cut,
    "silence": DisturbedRun.silence,
    "delay": DisturbedRun.delay,
}
