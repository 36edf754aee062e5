import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import tsd_casadi as tsd
from tsd_clients.service_process import ServiceProcess, free_endpoint

SHORT = ["--amplitude", "0.01", "--frequency", "1.0", "--laps", "2"]


def tsd_command(
    *arguments: str, timeout: float = 120.0, **environment: str
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "tsd_clients.command_line", *arguments],
        capture_output=True,
        text=True,
        timeout=timeout,
        env={**os.environ, **environment},
        check=False,
    )


def assert_refused(done: subprocess.CompletedProcess[str], *words: str, code: int = 1) -> None:
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    for word in words:
        assert word in done.stderr


@pytest.fixture(scope="module")
def connect(
    controller: tsd.Controller, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[list[str]]:
    endpoints = free_endpoint(), free_endpoint()
    database = tmp_path_factory.mktemp("cli") / "cli.sqlite"
    with (
        ServiceProcess(["controller", "--listen", endpoints[0]]),
        ServiceProcess(["learner", "--database", str(database), "--listen", endpoints[1]]),
    ):
        yield ["--connect", endpoints[0], "--connect", endpoints[1]]


def test_the_path_of_the_readme(connect: list[str], tmp_path: Path) -> None:
    for amplitude in ("0.01", "0.02"):
        learned = tsd_command(
            "learn",
            "squat",
            "--amplitude",
            amplitude,
            *SHORT[2:],
            "--model-error",
            "0.1",
            "--iterations",
            "2",
            "--json",
            "-",
            *connect,
        )
        assert learned.returncode == 0, learned.stderr
        runs = json.loads(learned.stdout)["runs"]
        assert [run["iteration"] for run in runs] == [0, 1, 2]
        assert runs[0]["rms_error_m"] > 20 * runs[1]["rms_error_m"]
        assert runs[1]["ac_rms_error_m"] > runs[2]["ac_rms_error_m"]
        assert all(run["transport"] == "zenoh" for run in runs)

    target = tmp_path / "feedforward.json"
    queried = tsd_command(
        "query",
        "squat",
        "--amplitude",
        "0.015",
        "--frequency",
        "1",
        "--json",
        str(target),
        *connect,
    )
    assert queried.returncode == 0, queried.stderr
    assert "generalised" in queried.stdout
    reply = json.loads(target.read_text())
    assert reply["kind"] == "generalised"
    assert len(reply["weights"][0]) == reply["basis"]["L"] == 25

    listed = tsd_command("database", "list", "--json", "-", *connect)
    entries = json.loads(listed.stdout)["entries"]
    assert [entry["parameters"]["amplitude"]["value"] for entry in entries] == [0.01, 0.02]

    simulated = tsd_command(
        "simulate",
        "squat",
        "--amplitude",
        "0.015",
        *SHORT[2:],
        "--model-error",
        "0.1",
        "--feedforward",
        "generalised",
        "--json",
        "-",
        *connect,
    )
    run = json.loads(simulated.stdout)
    assert run["feedforward"] == "generalised"
    assert run["rms_error_m"] < 1e-3
    assert not run["fell"]

    forgotten = tsd_command("database", "forget", str(entries[0]["entry"]), *connect)
    assert forgotten.returncode == 0
    assert "amplitude 0.01 m" in forgotten.stdout


def test_local_and_remote_controller_give_the_same_run(connect: list[str]) -> None:
    runs = []
    for choice in ("zenoh", "local"):
        done = tsd_command(
            "simulate",
            "squat",
            *SHORT,
            "--model-error",
            "0.1",
            "--seed",
            "3",
            "--controller",
            choice,
            "--json",
            "-",
            *connect,
        )
        assert done.returncode == 0, done.stderr
        runs.append(json.loads(done.stdout))
    for name in ("rms_error_m", "peak_error_m", "true_rms_error_m", "mean_abs_feedback", "ticks"):
        assert runs[0][name] == runs[1][name], name


def test_log_has_every_tick(connect: list[str], tmp_path: Path) -> None:
    import numpy as np

    from tsd_clients.run import LOG_UNITS

    target = tmp_path / "log.npz"
    done = tsd_command("simulate", "squat", *SHORT, "--log", str(target), "--json", "-", *connect)
    log = np.load(target)
    assert set(log.files) == set(LOG_UNITS)
    assert {len(log[name]) for name in log.files} == {json.loads(done.stdout)["ticks"]}


def test_amplitude_of_five_asks_for_metres() -> None:
    for arguments in (
        ("simulate", "squat", "--amplitude", "5"),
        ("learn", "squat", "--amplitude", "5"),
        ("query", "squat", "--amplitude", "5"),
    ):
        assert_refused(tsd_command(*arguments), "did you mean 0.05 m?")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("simulate", "squat", "--robot", "atlas"), ("no robot 'atlas'", "hermes_lower")),
        (("simulate", "jump"), ("'jump'", "'squat'")),
        (("simulate", "squat", "--frequency", "9"), ("frequency is 9", "0.05 to 1 Hz")),
        (("simulate", "squat", "--model-error", "-1"), ("model error", "0.1 is 10 %")),
        (("learn", "squat", "--iterations", "0"), ("iterations is 0",)),
        (("controller", "--listen", "127.0.0.1"), ("endpoint", "tcp/127.0.0.1:7447")),
        (("controller", "--robot", "nobody.yaml"), ("no robot 'nobody.yaml'",)),
        (("database", "list", "--connect", "somewhere"), ("endpoint", "PROTOCOL/ADDRESS:PORT")),
    ],
)
def test_bad_input_is_one_message(arguments: tuple[str, ...], words: tuple[str, ...]) -> None:
    assert_refused(tsd_command(*arguments), *words)


def test_nobody_to_talk_to() -> None:
    nowhere = ("--connect", free_endpoint())
    assert_refused(
        tsd_command("simulate", "squat", *nowhere), "no controller answered", "tsd controller"
    )
    assert_refused(tsd_command("database", "list", *nowhere), "no learner answered", "tsd learner")


def test_learned_without_an_entry(connect: list[str]) -> None:
    done = tsd_command(
        "simulate", "squat", "--amplitude", "0.055", "--feedforward", "learned", *connect
    )
    assert_refused(done, "nothing was learned", "tsd learn squat")


def test_missing_compiler_is_one_message(tmp_path: Path) -> None:
    done = tsd_command(
        "controller",
        "--listen",
        free_endpoint(),
        CC="no-such-compiler",
        TSD_CACHE_DIR=str(tmp_path),
    )
    assert_refused(done, "no C compiler found", "apt install gcc")


def test_wrong_usage_is_exit_code_2() -> None:
    assert tsd_command("simulate", "squat", "--amplitude", "wide").returncode == 2
    assert tsd_command("simulate", "squat", "--no-such-option").returncode == 2


def test_fall_is_reported_with_exit_code_3(connect: list[str]) -> None:
    done = tsd_command(
        "simulate",
        "squat",
        "--amplitude",
        "0.08",
        "--frequency",
        "1",
        "--model-error",
        "4",
        "--p-scale",
        "0.01",
        "--controller",
        "local",
        "--json",
        "-",
    )
    assert done.returncode == 3, done.stdout
    assert json.loads(done.stdout)["fell"]


def test_interrupted_client_ends_at_once_with_130(connect: list[str]) -> None:
    process = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "tsd_clients.command_line",
            "simulate",
            "squat",
            "--laps",
            "50",
            *connect,
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    time.sleep(6.0)
    assert process.poll() is None
    start = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=10.0)
    assert process.returncode == 130
    assert time.monotonic() - start < 2.0
    assert "Traceback" not in errors


def test_help_of_every_command_teaches() -> None:
    overview = tsd_command("--help").stdout
    for command in ("controller", "learner", "simulate", "learn", "query", "database", "demo"):
        assert command in overview
        assert tsd_command(command, "--help").returncode == 0
    text = tsd_command("simulate", "--help").stdout
    for option in (
        "--robot",
        "--amplitude",
        "--frequency",
        "--laps",
        "--feedforward",
        "--p-scale",
        "--model-error",
        "--controller",
        "--connect",
        "--seed",
        "--json",
    ):
        assert option in text


def test_unwritable_output_is_refused_before_the_run(tmp_path: Path) -> None:
    start = time.monotonic()
    for option in ("--json", "--log"):
        done = tsd_command("simulate", "squat", "--controller", "local", option, str(tmp_path))
        assert_refused(done, "output file", "writable")
    assert time.monotonic() - start < 15.0
