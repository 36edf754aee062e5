"""What runs here, how it is, and what is said of a service that does not answer."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import tsd_casadi as tsd
from tsd_casadi.exceptions import InvalidValue, MalformedMessage, ServiceNotReady
from tsd_casadi.wire.health import HealthMessage
from tsd_casadi.wire.keys import health_key, info_key
from tsd_clients.remote.remote_controller import RemoteController
from tsd_clients.remote.session import Session
from tsd_server.service_process import ServiceProcess, free_endpoint


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("status") / "run"


@pytest.fixture(scope="module")
def database(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("status") / "a.sqlite"


@pytest.fixture(scope="module")
def endpoint(folder: Path, controller: tsd.Controller) -> Iterator[str]:
    endpoint = free_endpoint()
    with ServiceProcess(["controller", "--listen", endpoint], run_directory=folder):
        yield endpoint


@pytest.fixture(scope="module")
def learner(folder: Path, database: Path, endpoint: str) -> Iterator[ServiceProcess]:
    arguments = ["learner", "--database", str(database), "--listen", free_endpoint()]
    with ServiceProcess(arguments, run_directory=folder) as service:
        yield service


def tsd_command(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "tsd_cli", *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        env={**os.environ, "TSD_RUN_DIR": str(folder), "COLUMNS": "200"},
        check=False,
    )


def ask_health(endpoint: str, robot: str, role: str) -> HealthMessage:
    session = Session(role, [endpoint])
    try:
        session.wait_for(robot)
        return HealthMessage.decode(session.query_one(health_key(robot, role)))
    finally:
        session.close()


@contextmanager
def frozen(pid: int) -> Iterator[None]:
    os.kill(pid, signal.SIGSTOP)
    # all of its threads; the signal alone is only under way
    os.waitid(os.P_PID, pid, os.WSTOPPED)
    try:
        yield
    finally:
        os.kill(pid, signal.SIGCONT)


def test_what_runs_here_is_listed_with_how_it_is(
    folder: Path, endpoint: str, learner: ServiceProcess, database: Path
) -> None:
    done = tsd_command(folder, "status", "--json", "-")
    assert done.returncode == 0, done.stderr
    services = json.loads(done.stdout)["services"]
    assert [each["health"]["role"] for each in services] == ["controller", "learner"]
    first, second = (each["record"] for each in services)
    assert first["endpoints"] == [endpoint]
    assert first["robot"] == first["subject"] == "hermes_lower"
    assert second["pid"] == learner.process.pid
    assert second["subject"] == str(database.resolve())
    assert first["instance"] == services[0]["health"]["instance"]
    shown = tsd_command(folder, "status")
    assert shown.returncode == 0
    for words in (endpoint, "hermes_lower", "answers, up", "controller/tick", "every"):
        assert words in shown.stdout


def test_nothing_runs_in_an_empty_folder(tmp_path: Path) -> None:
    done = tsd_command(tmp_path / "run", "status")
    assert done.returncode == 0
    assert "no service of yours runs here" in done.stdout


def test_health_counts_what_was_answered_and_refused(robot: tsd.Robot, endpoint: str) -> None:
    before = ask_health(endpoint, robot.name, "controller").answers["tick"]
    with RemoteController(robot.name, [endpoint]) as remote:
        for _ in range(7):
            remote.tick(robot.home, remote.command())
        command = remote.command()
        command["com.P"] = np.nan
        with pytest.raises(InvalidValue):
            remote.tick(robot.home, command)
    health = ask_health(endpoint, robot.name, "controller")
    after = health.answers["tick"]
    assert after.answered - before.answered == 7
    refused = after.refused["invalid_value"] - before.refused.get("invalid_value", 0)
    assert refused == 1
    assert after.failed == {}
    assert sum(after.latency.counts) == after.answered + sum(after.refused.values())
    assert health.ticks is not None
    assert sum(health.ticks.values()) == after.answered
    assert health.uptime > 0
    assert set(health.versions) == {"tsd_casadi", "zenoh", "messages", "tick"}


def test_the_learner_says_how_it_is_and_answers_for_each_robot(learner: ServiceProcess) -> None:
    endpoint = next(line for line in learner.output if " ready on " in line).split()[3].rstrip(":")
    session = Session("learner", [endpoint])
    try:
        session.wait_for("*")
        with pytest.raises(MalformedMessage):
            session.query_one("tsd/hermes_lower/learner/nonsense")
        (body,) = session.query(health_key("hermes_lower", "learner"))
        (all_robots,) = session.query(health_key("*", "learner"))
    finally:
        session.close()
    assert HealthMessage.decode(body).pid == learner.process.pid
    assert HealthMessage.decode(all_robots).robot == "*"


@pytest.mark.parametrize("role", ["controller", "learner"])
def test_a_second_one_is_refused_and_the_first_named(
    role: str, folder: Path, endpoint: str, learner: ServiceProcess, database: Path
) -> None:
    arguments = [role, "--listen", free_endpoint()]
    if role == "learner":
        # the same file by another path
        arguments += ["--database", str(database.parent / ".." / database.parent.name / "a.sqlite")]
    with pytest.raises(ServiceNotReady, match=rf"there is a {role} for .*since .*kill [0-9]+"):
        ServiceProcess(arguments, run_directory=folder)


def test_another_can_start_once_the_first_was_killed(tmp_path: Path) -> None:
    arguments = ["learner", "--database", str(tmp_path / "a.sqlite"), "--listen", free_endpoint()]
    with ServiceProcess(arguments, run_directory=tmp_path / "run") as first:
        first.process.kill()
        first.process.wait()
        with ServiceProcess(arguments, run_directory=tmp_path / "run"):
            pass


def test_a_frozen_service_is_said_to_be_frozen(
    folder: Path, endpoint: str, learner: ServiceProcess
) -> None:
    pid = learner.process.pid
    where = next(line for line in learner.output if " ready on " in line).split()[3].rstrip(":")
    with frozen(pid):
        start = time.monotonic()
        status = tsd_command(folder, "status")
        asked = tsd_command(folder, "database", "list", "--connect", where)
        duration = time.monotonic() - start
    assert status.returncode == 1
    assert f"process {pid} is stopped, 'kill -CONT {pid}'" in status.stdout
    assert "answers, up" in status.stdout  # the controller does
    assert asked.returncode == 1
    assert f"process {pid} is stopped" in asked.stderr
    assert duration < 30.0
    assert tsd_command(folder, "status").returncode == 0


def test_what_is_elsewhere_is_asked_by_its_endpoint(
    endpoint: str, learner: ServiceProcess, tmp_path: Path
) -> None:
    nobody = free_endpoint()
    where = next(line for line in learner.output if " ready on " in line).split()[3].rstrip(":")
    options = ["--connect", endpoint, "--connect", nobody, "--connect", where]
    done = tsd_command(tmp_path / "run", "status", *options, "--json", "-")
    assert done.returncode == 1
    first, second, third = json.loads(done.stdout)["services"]
    assert first["health"]["robot"] == "hermes_lower"
    assert second["trouble"] == f"nothing listens at {nobody}"
    assert third["health"]["role"] == "learner"
    assert third["health"]["database"]["entries"] == 0


def test_a_log_is_written_on_request_only(tmp_path: Path) -> None:
    endpoint = free_endpoint()
    arguments = ["learner", "--database", str(tmp_path / "a.sqlite"), "--listen", endpoint]
    with ServiceProcess(arguments) as quiet:
        pass
    assert len(quiet.output) == 1
    with ServiceProcess([*arguments, "--log-level", "debug"]) as service:
        session = Session("learner", [endpoint])
        try:
            session.wait_for("*")
            with pytest.raises(MalformedMessage):
                session.query_one("tsd/robot/learner/nonsense")
        finally:
            session.close()
    printed = "\n".join(service.output)
    assert "INFO tsd_server.service: learner of" in printed
    assert "DEBUG tsd_server.answering: tsd/robot/learner/nonsense refused" in printed


def test_info_is_the_same_for_everybody(robot: tsd.Robot, endpoint: str) -> None:
    """It is written once, with counters that go on."""
    session = Session("controller", [endpoint])
    try:
        session.wait_for(robot.name)
        first, second = (session.query_one(info_key(robot.name)) for _ in range(2))
    finally:
        session.close()
    assert first == second


def test_a_key_with_a_wildcard_is_answered_and_stops_nothing(
    robot: tsd.Robot, endpoint: str, learner: ServiceProcess
) -> None:
    where = next(line for line in learner.output if " ready on " in line).split()[3].rstrip(":")
    for at, role in ((endpoint, "controller"), (where, "learner")):
        session = Session(role, [at])
        try:
            session.wait_for(robot.name)
            list(session.zenoh.get(f"tsd/*/{role}/*", timeout=2.0))
            list(session.zenoh.get("**", timeout=2.0))
        finally:
            session.close()
        assert ask_health(at, robot.name, role).role == role
