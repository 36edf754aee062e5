"""The bounded form of ``python -m benchmarks.reliability``, and how a run is given up."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import tsd_casadi as tsd
from tsd_casadi.tick.missed import Cause, Missed
from tsd_clients.remote.remote_controller import RemoteController
from tsd_server.service_process import ServiceProcess, free_endpoint

ROOT = Path(__file__).parents[2]
# of the clock: a machine that runs tests is busy, and what it misses itself is counted too
PACE = "0.2"
PERIOD = 0.01  # s, for single questions
ABORTED = 4


@pytest.mark.parametrize(("kind", "times"), [("kill", 2), ("stop", 1), ("cut", 1), ("delay", 1)])
def test_robot_stands_and_every_missed_period_is_counted(
    controller: tsd.Controller, tmp_path: Path, kind: str, times: int
) -> None:
    out = tmp_path / "outcome.json"
    options = [kind, "--times", str(times), "--pace", PACE, "--json", str(out)]
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.reliability", *options],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    outcome = json.loads(out.read_text())[kind]
    assert outcome["gaps"] >= times
    assert outcome["exit_code"] == 130


@pytest.fixture
def endpoint(controller: tsd.Controller) -> str:
    return free_endpoint()


def until(remote: RemoteController, robot: tsd.Robot, cause: Cause | None) -> list[Cause]:
    """Ask until there is no answer for that cause, or one for None; gives the causes before."""
    causes: list[Cause] = []
    command = remote.command()
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        answer = remote.tick_within(robot.home, command, PERIOD)
        found = answer.cause if isinstance(answer, Missed) else None
        if found is cause:
            return causes
        if found is not None:
            causes.append(found)
    raise AssertionError(f"never {cause}, but {set(causes)}")


def test_causes_are_told_apart_and_answers_come_back(robot: tsd.Robot, endpoint: str) -> None:
    arguments = ["controller", "--listen", endpoint]
    with ServiceProcess(arguments) as first, RemoteController(robot.name, [endpoint]) as remote:
        until(remote, robot, None)
        command = remote.command()
        command["com.P"] = np.nan
        refused = remote.tick_within(robot.home, command, 10.0)
        assert isinstance(refused, Missed) and refused.cause is Cause.REFUSED
        assert "com.P[0] is nan" in refused.detail
        first.process.send_signal(signal.SIGSTOP)
        os.waitid(os.P_PID, first.process.pid, os.WSTOPPED)
        until(remote, robot, Cause.LATE)
        # its lease runs out
        until(remote, robot, Cause.NOTHING_THERE)
        first.process.send_signal(signal.SIGCONT)
        until(remote, robot, None)
        first.process.kill()
        first.process.wait()
        until(remote, robot, Cause.NOTHING_THERE)
        with ServiceProcess(arguments):
            # the new instance is looked at first
            assert Cause.ERROR in until(remote, robot, None)
        assert remote.foreign_replies == 0


def test_late_replies_are_never_applied(robot: tsd.Robot, endpoint: str) -> None:
    arguments = ["controller", "--listen", endpoint]
    with ServiceProcess(arguments) as service, RemoteController(robot.name, [endpoint]) as remote:
        until(remote, robot, None)
        service.process.send_signal(signal.SIGSTOP)
        os.waitid(os.P_PID, service.process.pid, os.WSTOPPED)
        low = remote.command()
        low["com.reference"][2] -= 0.01
        assert isinstance(remote.tick_within(robot.home, low, PERIOD), Missed)
        service.process.send_signal(signal.SIGCONT)
        here = remote.command()
        answer = remote.tick_within(robot.home, here, 10.0)
        assert not isinstance(answer, Missed)
        np.testing.assert_array_equal(answer.tau, remote.tick(robot.home, here).tau)
        assert remote.late_replies == 1


@pytest.mark.parametrize("pace", [[], ["--pace", PACE]])
def test_a_run_that_is_given_up_keeps_what_it_has(
    robot: tsd.Robot, tmp_path: Path, pace: list[str]
) -> None:
    endpoint = free_endpoint()
    options = ["--connect", endpoint, "--patience", "1", "--laps", "1000", *pace]
    files = ["--json", str(tmp_path / "run.json"), "--log", str(tmp_path / "run.npz")]
    with (
        ServiceProcess(["controller", "--listen", endpoint]) as service,
        RemoteController(robot.name, [endpoint]) as watch,
        subprocess.Popen(
            [sys.executable, "-m", "tsd_cli", "simulate", "squat", *options, *files],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as run,
    ):
        while watch.info().ticks_served < 50:
            assert run.poll() is None
        service.process.kill()
        out, err = run.communicate(timeout=60)
    assert run.returncode == ABORTED, err
    assert out == ""  # nothing was measured
    assert (
        "run.npz and " in err
        and "note: aborted after" in err
        and "error: no " in err
        and "Traceback" not in err
    )
    summary = json.loads((tmp_path / "run.json").read_text())
    assert summary["aborted"] and summary["ticks"] >= 50
    with np.load(tmp_path / "run.npz") as log:
        assert len(log["time"]) == summary["ticks"]
    if pace:
        assert summary["missed"]["nothing there"] > 50


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_learning_that_is_ended_early_keeps_what_was_run_before(
    robot: tsd.Robot, controller: tsd.Controller, tmp_path: Path, number: signal.Signals
) -> None:
    """The controller is killed, or the user presses Ctrl-C."""
    endpoint, learner = free_endpoint(), free_endpoint()
    options = ["--connect", endpoint, "--connect", learner, "--patience", "1", "--iterations", "9"]
    file = ["--json", str(tmp_path / "run.json")]
    database = str(tmp_path / "learned.sqlite")
    with (
        ServiceProcess(["controller", "--listen", endpoint]) as service,
        ServiceProcess(["learner", "--listen", learner, "--database", database]),
        RemoteController(robot.name, [endpoint]) as watch,
        subprocess.Popen(
            [
                sys.executable,
                "-m",
                "tsd_cli",
                "learn",
                "squat",
                "--frequency",
                "1",
                *options,
                *file,
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        ) as run,
    ):
        # a second of standing and at least three laps of one are a repetition
        while watch.info().ticks_served < 6000:
            assert run.poll() is None
        (service.process if number == signal.SIGKILL else run).send_signal(number)
        _, err = run.communicate(timeout=60)
    assert run.returncode == (ABORTED if number == signal.SIGKILL else 130), err
    assert "nothing was recorded of it" in err and "Traceback" not in err
    *done, last = json.loads((tmp_path / "run.json").read_text())["runs"]
    assert done and not any(each["aborted"] for each in done)
    assert last["aborted"]
