import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import tsd_casadi as tsd
from tsd_casadi.repetition.log_fields import LOG_FIELDS
from tsd_clients import RemoteController, RemoteLearner
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
        assert list(runs[0]["errors"]) == ["com.z", "com.x", "com.y"]
        first, second, third = (run["errors"]["com.z"] for run in runs)
        assert first["rms"] > 20 * second["rms"]
        assert second["ac_rms"] > third["ac_rms"]
        assert runs[0]["rank"] > 20 * runs[1]["rank"]
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
    assert run["errors"]["com.z"]["rms"] < 1e-3
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
    assert [len(place["errors"]) for place in result["places"]] == [2, 2, 2]
    assert len(result["runs"]) == 6
    rows = [line.split() for line in done.stdout.splitlines()]
    (row,) = [row for row in rows if row[:2] == ["1", "0.015"]]
    assert row[:5] == ["1", "0.015", "1", "-0.01", "com.z"]


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
    account = result["contractions"][0]
    assert [each["axis"] for each in result["contractions"]] == ["com.z", "com.x", "com.y"]
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
    for name in ("errors", "rank", "ticks"):
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
        "--axes",
        "com.z",
        "--period",
        "0.002",
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
    assert run["gains"]["P"] == [default["com.P"][2]]
    assert run["gains"]["D"] == pytest.approx([1.5 * default["com.D"][2]])
    assert list(run["errors"]) == ["com.z"]
    assert run["period_s"] == 0.002
    assert run["ticks"] == pytest.approx(run["laps_run"] * 500 + 500, abs=20)
    assert run["steady"]
    assert run["label"].endswith("hardware")


@pytest.mark.parametrize("ending", [".npz", ".csv"])
def test_log_has_every_tick(connect: list[str], tmp_path: Path, ending: str) -> None:
    target = tmp_path / f"log{ending}"
    done = tsd_command("simulate", "squat", *SHORT, "--log", str(target), "--json", "-", *connect)
    ticks = json.loads(done.stdout)["ticks"]
    if ending == ".npz":
        log = np.load(target)
        # and whose log it is; the request of a tick that failed only where one did
        assert set(log.files) == {*LOG_FIELDS, "axes", "model", "outline", "robot", "summary"}
        assert {len(log[name]) for name in LOG_FIELDS} == {ticks}
        assert log["axes"].tolist() == ["com.z", "com.x", "com.y"]
    else:
        header, *rows = target.read_text().splitlines()
        assert {name.partition("[")[0] for name in header.split(",")} == set(LOG_FIELDS)
        assert "error[com.x]" in header.split(",")
        assert {row.count(",") for row in rows} == {header.count(",")}
        assert len(rows) == ticks
    assert [item.name for item in tmp_path.iterdir()] == [target.name]


def test_a_region_without_a_range_says_what_it_chose(connect: list[str]) -> None:
    # longer than a robot can do it: refused after the region was chosen
    arguments = ("--auto", "1", "--region", "amplitude", "--region", "height", "--laps", "1")
    done = tsd_command("learn", "squat", *arguments, *connect)
    assert_refused(
        done, "laps is 1", "region of amplitude: 0.02 to 0.08 m", "height: -0.05 to 0.06"
    )


OWN = """
from dataclasses import dataclass
import numpy as np
from tsd_casadi.motions.motion import Motion, Offset
from tsd_casadi.motions.parameter import parameter

@dataclass(frozen=True)
class Nod(Motion):
    angle: float = parameter("rad", "half of peak to peak", low=0.0, extent=True)
    frequency: float = parameter("Hz", "laps per second", default=1.0)
    name = "nod"

    def axes(self, robot):
        return ("torso.ry",)

    def offset(self, phase):
        sine, cosine = self.angle * np.sin([phase]), self.angle * np.cos([phase])
        return Offset(sine, cosine, -sine)
"""


def test_a_motion_of_ones_own_is_learned_stored_and_carried_elsewhere(
    connect: list[str], tmp_path: Path
) -> None:
    path, exported, other = (tmp_path / name for name in ("own.py", "out.json", "other.sqlite"))
    path.write_text(OWN)
    motion = (f"{path}:Nod", "--angle", "0.05")
    one_axis = ("--axes", "torso.ry", "--model-error", "0.1")
    done = tsd_command("learn", *motion, "--laps", "2", *one_axis, *connect)
    assert done.returncode == 0, done.stderr
    assert "torso.ry" in done.stdout
    asked = ("query", *motion, "--json", "-", *connect)
    answer = json.loads(tsd_command(*asked).stdout)
    assert (answer["motion"], answer["kind"]) == ("nod", "learned")
    assert answer["axes"] == [{"name": "torso.ry", "unit": "rad"}]
    assert answer["declaration"]["parameters"][0]["unit"] == "rad"
    listed = json.loads(tsd_command("database", "list", "--json", "-", *connect).stdout)
    database = listed["database"]
    # an entry for fewer axes serves a run of more
    more = ("simulate", *motion, "--laps", "2", "--feedforward", "learned", "--json", "-")
    done = tsd_command(*more, *connect)
    assert json.loads(done.stdout)["iteration"] == 1
    assert "nothing was learned along com.x, com.y, com.z yet: zero there" in done.stderr
    for arguments in (
        ("verify", "--database", database),
        ("export", str(exported), "--database", database),
        ("import", str(exported), "--database", str(other)),
        ("verify", "--database", str(other)),
    ):
        done = tsd_command("database", *arguments)
        assert done.returncode == 0, done.stderr
    assert f"{len(listed['entries'])} entries, nothing wrong" in done.stdout
    # an edited file is another motion: nothing was learned of it
    path.write_text(OWN.replace("default=1.0", "default=1.0, low=0.1"))
    assert_refused(tsd_command(*more, *connect), "no entry for nod")


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
    assert_refused(done, "no entry for squat", "tsd learn squat")


def test_missing_compiler_is_one_message(tmp_path: Path) -> None:
    done = tsd_command(
        "controller",
        "--listen",
        free_endpoint(),
        CC="no-such-compiler",
        TSD_CACHE_DIR=str(tmp_path),
    )
    assert_refused(done, "no C compiler found", "apt install gcc")


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


def test_a_fall_while_learning_is_shown_with_exit_code_3(connect: list[str]) -> None:
    far = ["--amplitude", "0.08", "--frequency", "1", "--model-error", "4", "--p-scale", "0.01"]
    done = tsd_command("learn", "squat", *far, "--controller", "local", "--json", "-", *connect)
    assert done.returncode == 3, done.stderr
    (run,) = json.loads(done.stdout)["runs"]
    assert run["fell"] and any("not recorded" in note for note in run["notes"])
    assert "error: the robot fell in squat" in done.stderr


def test_interrupted_client_ends_at_once_with_130(connect: list[str]) -> None:
    with RemoteController("hermes_lower", [connect[1]]) as remote:
        before = remote.info().ticks_served
        process = subprocess.Popen(
            [sys.executable, "-m", "tsd_cli", "simulate", "squat", "--laps", "50", *connect],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            # a shell's job in the background would have it ignored
            preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
        )
        while remote.info().ticks_served == before:
            assert process.poll() is None
    start = time.monotonic()
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=10.0)
    assert process.returncode == 130
    assert time.monotonic() - start < 2.0
    assert (output, errors.splitlines()[-1]) == ("", "interrupted")
    assert "Traceback" not in errors


def test_clients_say_in_one_line_what_they_are(connect: list[str]) -> None:
    with RemoteController("hermes_lower", [connect[1]]) as controller:
        text = f"<RemoteController of hermes_lower at {connect[1]}: instance "
        assert repr(controller).startswith(text)
    with RemoteLearner([connect[3]]) as learner:
        assert repr(learner) == f"<RemoteLearner at {connect[3]}>"


def test_a_compilation_is_shown_and_not_printed_by_the_library(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    cache.mkdir(mode=0o700)
    arguments = ("simulate", "squat", *SHORT, "--controller", "local", "--json", "-")
    first, second = (tsd_command(*arguments, TSD_CACHE_DIR=str(cache)) for _ in range(2))
    line = "compiling the controller of hermes_lower (once, about 20 s) ..."
    assert " ".join(first.stderr.split()) == line
    assert second.stderr == ""
    assert json.loads(first.stdout)["errors"] == json.loads(second.stdout)["errors"]
