import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pytest

import tsd_casadi as tsd
from tsd_server.service_process import ServiceProcess, free_endpoint

SHORT = ["--amplitude", "0.01", "--frequency", "1.0", "--laps", "2"]


def tsd_command(
    *arguments: str, timeout: float = 120.0, **environment: str
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "tsd_cli", *arguments],
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


def test_auto_goes_where_the_learner_knows_least(connect: list[str], tmp_path: Path) -> None:
    target = tmp_path / "places.json"
    arguments = ("--region", "amplitude=0.01:0.02", "--height", "-0.01", *SHORT[2:])
    arguments += ("--model-error", "0.1")
    done = tsd_command("learn", "squat", "--auto", "3", *arguments, "--json", str(target), *connect)
    assert done.returncode == 0, done.stderr
    result = json.loads(target.read_text())
    places = [place["parameters"] for place in result["places"]]
    assert {(place["frequency"], place["height"]) for place in places} == {(1.0, -0.01)}
    # the middle, then the ends
    assert places[0]["amplitude"] == 0.015
    assert {place["amplitude"] for place in places[1:]} == {0.01, 0.02}
    # nothing known of this height, then one entry, then two
    known = [place["standard_deviation"] is not None for place in result["places"]]
    assert known == [False, False, True]
    assert [len(place["rms_errors_m"]) for place in result["places"]] == [2, 2, 2]
    assert len(result["runs"]) == 6
    assert "amplitude 0.015 m, frequency 1 Hz, height -0.01 m" in done.stdout


def test_stable_learning_stops_by_itself_and_says_what_it_did(
    connect: list[str], tmp_path: Path
) -> None:
    target = tmp_path / "stable.json"
    arguments = ["--amplitude", "0.012", *SHORT[2:], "--model-error", "0.1", "--rule", "stable"]
    arguments += ["--iterations", "9", "--patience", "1", "--first", "generalised", "--restart"]
    arguments += ["--height", "0.01"]
    done = tsd_command("learn", "squat", *arguments, "--json", str(target), *connect)
    assert done.returncode == 0, done.stderr
    result = json.loads(target.read_text())
    # from what other tests have learned, if they ran before
    starts_from = result["runs"][0]["feedforward"]
    assert starts_from == "generalised" or "nothing to generalise from yet" in done.stderr
    assert 3 <= len(result["runs"]) < 10
    (account,) = result["contractions"]
    assert account["parameters"] == {"amplitude": 0.012, "frequency": 1.0, "height": 0.01}
    assert account["axis"] == "com.z"
    assert account["plain"][5] > 0.9 > account["predicted"][5]
    assert "predicted" in done.stdout
    assert f"{account['plain'][5]:.2f}" in done.stdout


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


def test_options_of_the_simulated_robot_reach_the_run(controller: tsd.Controller) -> None:
    done = tsd_command(
        "simulate",
        "squat",
        *SHORT,
        "--controller",
        "local",
        "--height",
        "0.03",
        "--d-scale",
        "1.5",
        "--link-error",
        "0.05",
        "--link-seed",
        "7",
        "--hardware",
        "lag, friction",
        "--json",
        "-",
    )
    assert done.returncode == 0, done.stderr
    run = json.loads(done.stdout)
    assert run["hardware"] == ["friction", "lag"]
    assert (run["model_error"], run["link_error"], run["link_error_seed"]) == (0.0, 0.05, 7)
    assert (run["p_scale"], run["d_scale"]) == (1.0, 1.5)
    default = controller.command()
    assert run["gains"]["P"] == default["com.P"].tolist()
    assert run["gains"]["D"] == pytest.approx((1.5 * default["com.D"]).tolist())
    assert run["steady"]
    assert run["label"].endswith("hardware")


def test_log_has_every_tick(connect: list[str], tmp_path: Path) -> None:
    import numpy as np

    from tsd_casadi.repetition.run import LOG_UNITS

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
        assert_refused(tsd_command(*arguments), "did you mean 0.05 or 0.005 m?")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("simulate", "squat", "--robot", "atlas"), ("no robot 'atlas'", "hermes_lower")),
        (("simulate", "jump"), ("'jump'", "'squat'")),
        (("simulate", "squat", "--frequency", "9"), ("frequency is 9", "0.05 to 1 Hz")),
        (("simulate", "squat", "--model-error", "-1"), ("model error", "0.1 is 10 %")),
        (("simulate", "squat", "--hardware", "rust"), ("hardware is rust", "friction", "all")),
        (("simulate", "squat", "--hardware", "lag,rust"), ("hardware is rust,", "flat_feet")),
        (("learn", "squat", "--hardware", "lag;noise"), ("hardware is lag;noise", "flat_feet")),
        (("simulate", "squat", "--link-error", "1"), ("model error", "0.1 is 10 %")),
        (("simulate", "squat", "--height", "0.5"), ("height is 0.5", "-0.05 to 0.06 m")),
        (("query", "squat", "--amplitude", "0.03", "--height", "5"), ("height is 5",)),
        (("simulate", "squat", "--d-scale", "0", "--controller", "local"), ("d scale is 0",)),
        (("simulate", "squat", "--p-scale", "-1", "--controller", "local"), ("p scale is -1",)),
        (("learn", "squat", "--iterations", "0"), ("iterations is 0",)),
        (("learn", "squat", "--region", "amplitude"), ("--region", "--auto")),
        (("learn", "squat", "--auto", "2", "--region", "depth=0:1"), ("depth", "0.02:0.08")),
        (("learn", "squat", "--auto", "2", "--region", "amplitude=0:1"), ("amplitude", "0.08")),
        (("reproduce", "--page", "report"), ("--page", ".md")),
        (("reproduce", "--figure", "7"), ("figure is 7", "2, 3, 4, 5, 6")),
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


def test_a_controller_of_other_files_is_refused(
    connect: list[str], write_robot: Callable[..., Path]
) -> None:
    other = str(write_robot(lambda document: document["posture"].update(P=41.0)))
    done = tsd_command("simulate", "squat", "--robot", other, *connect)
    assert_refused(done, "started with other files of hermes_lower", "same --robot")


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
            "tsd_cli",
            "simulate",
            "squat",
            "--laps",
            "50",
            *connect,
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # a shell's job in the background would have it ignored
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
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
        "--d-scale",
        "--height",
        "--model-error",
        "--link-error",
        "--link-seed",
        "--hardware",
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
