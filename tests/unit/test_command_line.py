"""The command line without any service: help, refusals, what loads and what Ctrl-C does."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from tsd_casadi import __version__
from tsd_casadi.center_of_mass.correction import CenterOfMassCorrection
from tsd_casadi.center_of_mass.static_chain import StaticChain
from tsd_casadi.database.database import Database
from tsd_casadi.exceptions import EntryNotFound
from tsd_casadi.learning.context import Context
from tsd_casadi.motions.catalogue import shipped_motions
from tsd_casadi.repetition.record import context_of
from tsd_casadi.robot import description_path
from tsd_casadi.robot.robot import Robot
from tsd_cli import command_line
from tsd_cli.actions import robots
from tsd_clients.console.table import console

COMMANDS = [
    [],
    *(
        text.split()
        for text in (
            "controller",
            "learner",
            "simulate",
            "learn",
            "explain",
            "log",
            "log show",
            "log plot",
            "log video",
            "log cut",
            "log convert",
            "log recover",
            "calibrate",
            "query",
            "demo",
            "reproduce",
            "database",
            "database list",
            "database forget",
            "database export",
            "database import",
            "database verify",
            "motion",
            "motion list",
            "motion show",
            "robot",
            "robot list",
        )
    ),
]
HEAVY = {
    "numpy",
    "scipy",
    "sklearn",
    "casadi",
    "pinocchio",
    "pinocchio_casadi",
    "mujoco",
    "matplotlib",
    "zenoh",
    "tsd_experiments",
    "tsd_server",
}


class Outcome(NamedTuple):
    code: int
    out: str
    err: str


Tsd = Callable[..., Outcome]


@pytest.fixture
def tsd(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Iterator[Tsd]:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "dumb")

    def run(*arguments: str) -> Outcome:
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            command_line.run(arguments)
        code = ended.value.code
        assert isinstance(code, int)
        return Outcome(code, *capsys.readouterr())

    before, console.width = console.width, 80
    try:
        yield run
    finally:
        console.width = before


@pytest.mark.parametrize("option", ["-h", "--help"])
@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_help_fits_eighty_columns_and_teaches_by_example(
    tsd: Tsd, command: list[str], option: str
) -> None:
    done = tsd(*command, option)
    assert (done.code, done.err) == (0, "")
    assert all(len(line) <= 80 for line in done.out.splitlines())
    if command not in (
        ["database"],
        ["log"],
        ["motion"],
        ["robot"],
    ):  # groups: their commands have them
        assert f"\n   tsd {' '.join(command)}" in done.out


def test_what_every_option_was_called_it_is_still_called(tsd: Tsd) -> None:
    commands = (("learn", "squat"), ("simulate", "squat"), ("calibrate",))
    text = "".join(tsd(*command, "-h").out for command in commands)
    shared = "--robot --model-error --link-error --link-seed --hardware --controller --connect"
    motion = "--amplitude --frequency --height --axes"
    repetition = "--laps --period --p-scale --d-scale --com-correction --seed"
    single = "--feedforward --json --log"
    learning = (
        "--pace --patience --iterations --restart --rule --stop-after --first --auto --region"
    )
    calibration = "--out --poses --noise --inclinometer --mass-prior --center-prior"
    for option in " ".join((shared, motion, repetition, single, learning, calibration)).split():
        assert f" {option} " in text, option


def test_version(tsd: Tsd) -> None:
    assert tsd("--version") == (0, f"tsd {__version__}\n", "")


def test_python_runs_the_package() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tsd_cli", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"tsd {__version__}\n"


def test_help_loads_nothing_heavy() -> None:
    program = (
        "import sys, tsd_cli.command_line as c\n"
        "try: c.run(['learn', '--help'])\n"
        "finally: print(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    loaded = {name.partition(".")[0] for name in done.stderr.split()}
    assert "typer" in loaded
    assert not loaded & HEAVY


@pytest.mark.parametrize(
    "arguments",
    [
        "simulate squat --amplitude wide",
        "simulate squat --no-such-option",
        "simulate",
        "lear squat",
        "learn squat --rule best",
        "query squat",
        "simulate sway --height 0.01",
        "simulate --amplitude 0.03",
        "simulate squat sway",
    ],
)
def test_wrong_usage_is_exit_code_2(tsd: Tsd, arguments: str) -> None:
    done = tsd(*arguments.split())
    assert (done.code, done.out) == (2, "")
    assert "Usage: tsd" in done.err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("simulate squat --robot atlas", ["no robot 'atlas'", "hermes_lower"]),
        ("simulate jump", ["'jump'", "'squat'"]),
        ("simulate my_motion.py:Bounce", ["my_motion.py", "cannot be read"]),
        ("simulate wave.csv --scale 2", ["wave.csv", "cannot be read"]),
        ("simulate file", ["'file'", "wave.csv"]),
        ("simulate reach", ["the task of reach", "frame task", "hermes_lower", "robot file"]),
        ("motion show reach", ["the task of reach", "frame task", "hermes_lower"]),
        ("motion show sqaut", ["did you mean 'squat'?"]),
        ("simulate twist --amplitude 2", ["amplitude is 2", "rad for hermes_lower"]),
        ("simulate squat --axes com.w", ["--axes is 'com.w'", "com.x, com.y, com.z"]),
        ("simulate squat --axes com.z,com.z", ["'com.z' twice"]),
        ("simulate squat --axes torso.rZ", ["did you mean 'torso.rz'?"]),
        ("simulate squat --axes ,", ["--axes is ''"]),
        ("learn squat --axes hand.x", ["'hand.x'", "pelvis.rx"]),
        ("query squat --amplitude 0.03 --axes z", ["--axes is 'z'"]),
        ("simulate squat --period 0.01 --controller local", ["period is 0.01 s", "0.00025"]),
        ("simulate squat --period 0 --controller local", ["period is 0 s"]),
        ("learn twist --auto 1 --region height", ["with one of amplitude, frequency"]),
        ("database verify --database no.sqlite", ["no.sqlite", "no file"]),
        ("database export a.json --database no.sqlite", ["no.sqlite", "no file"]),
        ("database import no.json --database a.sqlite", ["no.json"]),
        ("simulate sqaut", ["did you mean 'squat'?"]),
        ("simulate squat --amplitude 5", ["did you mean 0.05 or 0.005 m?"]),
        ("learn squat --amplitude 0.5", ["did you mean 0.05 or 0.005 m?"]),
        ("query squat --amplitude 5", ["did you mean 0.05 or 0.005 m?"]),
        ("simulate squat --frequency 9", ["frequency is 9", "0.05 to 1 Hz"]),
        ("simulate squat --model-error -1", ["model error", "0.1 is 10 %"]),
        ("simulate squat --hardware rust", ["hardware is rust", "friction", "all"]),
        ("simulate squat --hardware lag,rust", ["hardware is rust,", "flat_feet"]),
        ("learn squat --hardware lag;noise", ["hardware is lag;noise", "flat_feet"]),
        ("simulate squat --hardware lagg", ["did you mean 'lag'?"]),
        ("simulate squat --link-error 1", ["model error", "0.1 is 10 %"]),
        ("simulate squat --height 0.5", ["height is 0.5", "-0.05 to 0.06 m"]),
        ("query squat --amplitude 0.03 --height 5", ["height is 5"]),
        ("simulate squat --d-scale 0 --controller local", ["d scale is 0"]),
        ("simulate squat --p-scale -1 --controller local", ["p scale is -1"]),
        ("simulate squat --log run.txt", ["run.txt", "ends in .csv or .mcap or .npz"]),
        ("simulate squat --video run.avi", ["run.avi", "ends in .mp4 or .gif"]),
        ("learn squat --video no/run.mp4", ["no/run.mp4", "there is no folder"]),
        ("simulate squat --video run.mp4 --video-size 640", ["'640'", "640x480"]),
        ("simulate squat --video run.mp4 --video-size 641x480", ["film width is 641", "even"]),
        ("log video none.npz run.mp4", ["none.npz"]),
        ("log video none.npz run.txt", ["ends in .mp4 or .gif"]),
        ("learn squat --iterations 0", ["iterations is 0"]),
        ("learn squat --region amplitude", ["--region", "--auto"]),
        ("learn squat --auto 2 --region depth=0:1", ["depth", "0.02:0.08"]),
        ("learn squat --auto 2 --region heigth", ["did you mean 'height'?"]),
        ("learn squat --auto 2 --region amplitude=0:1", ["amplitude", "0.08"]),
        ("learn squat --com-correction none.json", ["none.json", "tsd calibrate"]),
        ("reproduce --page report", ["--page", ".md"]),
        ("reproduce --figure 7", ["figure is 7", "2, 3, 4, 5, 6"]),
        ("controller --listen 127.0.0.1", ["endpoint", "tcp/127.0.0.1:7447"]),
        ("controller --robot nobody.yaml", ["no robot 'nobody.yaml'"]),
        ("learner --database nowhere/d.sqlite", ["no folder nowhere"]),
        ("database list --connect somewhere", ["endpoint", "PROTOCOL/ADDRESS:PORT"]),
    ],
)
def test_what_cannot_be_done_is_one_message(
    tsd: Tsd,
    arguments: str,
    words: list[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("tsd_server.serve.end_at_once", lambda: None)  # the tests' own signals
    done = tsd(*arguments.split())
    assert (done.code, done.out) == (1, "")
    assert done.err.startswith("error: ")
    assert "Traceback" not in done.err
    for word in words:
        assert word in done.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", ["--json", "--log"])
@pytest.mark.parametrize(("place", "reason"), [("", "is a folder"), ("no/x.csv", "no folder")])
def test_outputs_are_checked_before_the_work(
    tsd: Tsd, tmp_path: Path, option: str, place: str, reason: str
) -> None:
    arguments = ("simulate", "squat", "--controller", "local", option, str(tmp_path / place))
    done = tsd(*arguments)
    assert (done.code, done.out) == (1, "")
    assert "output file" in done.err
    assert reason in done.err
    assert list(tmp_path.iterdir()) == []


def test_robots_are_listed(tsd: Tsd, tmp_path: Path) -> None:
    target = tmp_path / "robots.json"
    shown = tsd("robot", "list", "--json", str(target))
    assert (shown.code, shown.err) == (0, "")
    words = " ".join(shown.out.split())
    assert "hermes_lower 17 circle, lean, squat, sway, twist" in words
    assert "g1 29 circle, lean, reach, squat, sway, twist" in words
    robots = {robot["name"]: robot for robot in json.loads(target.read_text())["robots"]}
    assert robots.keys() == {"g1", "hermes_lower", "talos"}
    hermes = robots["hermes_lower"]
    assert len(hermes["joints"]) == 17
    assert Path(hermes["file"]).is_file()
    assert json.loads(tsd("robot", "list", "--json", "-").out) == {"robots": [*robots.values()]}


def test_robots_without_their_package_are_told_together(
    tsd: Tsd, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(description_path, "find_package", lambda name: None)
    done = tsd("robot", "list")
    rows = {row[0]: row[1:] for row in map(str.split, done.out.splitlines()) if row}
    assert rows["g1"][:1] == rows["talos"][:1] == ["-"]
    assert rows["hermes_lower"][:1] == ["17"]
    words = " ".join(done.out.split())
    assert (
        "g1, talos: field 'urdf': names the package 'example-robot-data', which is not installed"
        in words
    )
    assert words.count("is not installed") == 1
    assert "pip install '.[robots]' in the project's folder" in words


OWN = """
from dataclasses import dataclass
import numpy as np
from tsd_casadi.motions.motion import Motion, Offset
from tsd_casadi.motions.parameter import parameter

@dataclass(frozen=True)
class Bounce(Motion):
    hop_size: float = parameter("m", "half of peak to peak", low=0.0, extent=True)
    frequency: float = parameter("Hz", default=0.5)
    name = "bounce"

    def axes(self, robot):
        return ("com.z",)

    def offset(self, phase):
        sine, cosine = self.hop_size * np.sin([phase]), self.hop_size * np.cos([phase])
        return Offset(sine, cosine, -sine)
"""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "my_motion.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    return "my_motion.py:Bounce"


def test_a_motions_parameters_are_options_of_whatever_takes_it(tsd: Tsd, own: str) -> None:
    for command in ("simulate", "learn", "query"):
        for arguments in ((command, own, "-h"), (command, "--hop-size", "0.1", own, "-h")):
            text = tsd(*arguments).out
            assert "--hop-size" in text
            assert "Half of peak to peak" in text
            assert "--height" not in text
    assert "--amplitude" in tsd("simulate", "--robot", "hermes_lower", "twist", "-h").out
    assert "RADIANS" in tsd("simulate", "twist", "-h").out


@pytest.mark.parametrize("is_corrected", [True, False])
def test_a_question_is_asked_in_the_context_that_is_learned_in(
    robot: Robot, tsd: Tsd, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_corrected: bool
) -> None:
    terms = StaticChain(robot).terms()
    corrected = CenterOfMassCorrection(robot, terms, np.zeros((terms.size, terms.size)))
    corrected.save(tmp_path / "com.json")
    contexts = []

    class Nothing:
        def query_message(self, motion: str, /, *, context: Context, **_: Any) -> Any:
            contexts.append(context)
            raise EntryNotFound("no entry")

    monkeypatch.setattr("tsd_cli.actions.ask.open_learner", lambda _: nullcontext(Nothing()))
    options = ("--com-correction", str(tmp_path / "com.json")) if is_corrected else ()
    done = tsd("query", "squat", "--amplitude", "0.03", "--robot", str(robot.path), *options)
    assert done.err == "error: no entry\n"
    assert contexts == [context_of(robot, corrected.fingerprint if is_corrected else "")]


def test_what_a_motion_of_ones_own_needs_is_asked_for(tsd: Tsd, own: str) -> None:
    done = tsd("simulate", own, "--controller", "local")
    assert (done.code, done.out) == (2, "")
    assert "Missing option '--hop-size'" in done.err
    assert tsd("simulate", own, "--hop", "0.1").code == 2


def test_a_parameter_named_like_an_option_is_refused(tsd: Tsd, own: str) -> None:
    Path("my_motion.py").write_text(OWN.replace("hop_size", "seed"))
    done = tsd("simulate", own, "--seed", "3")
    assert (done.code, done.out) == (1, "")
    assert "parameter of bounce is 'seed', expected another name" in done.err


def test_motions_are_listed_with_their_parameters(tsd: Tsd) -> None:
    shown = tsd("motion", "list")
    words = " ".join(shown.out.split())
    assert (shown.code, shown.err) == (0, "")
    assert "squat amplitude m 0.03" in words
    assert "twist amplitude rad" in words
    motions = json.loads(tsd("motion", "list", "--json", "-").out)["motions"]
    assert [motion["name"] for motion in motions] == sorted(shipped_motions())


def test_a_motion_is_shown_with_its_ranges_on_a_robot(tsd: Tsd, own: str) -> None:
    words = " ".join(tsd("motion", "show", "squat").out.split())
    assert "amplitude m 0.03" in words
    assert "0.001 0.08" in words
    assert "moves com.z; learns com.z, com.x, com.y" in words
    shown = json.loads(tsd("motion", "show", own, "--json", "-").out)
    assert (shown["name"], shown["axes"]) == ("bounce", ["com.z"])
    hop, frequency = shown["parameters"]
    assert (hop["low"], frequency["low"], frequency["high"]) == (0.0, 0.05, 1.0)
    assert 0.05 < hop["high"] < 0.5


def test_a_database_is_carried_from_file_to_file(tsd: Tsd, tmp_path: Path) -> None:
    here, there, file = (str(tmp_path / name) for name in ("a.sqlite", "b.sqlite", "all.json"))
    with Database(here):
        pass
    assert "0 entries, nothing wrong" in tsd("database", "verify", "--database", here).out
    assert "wrote 0 entries" in tsd("database", "export", file, "--database", here).out
    done = tsd("database", "import", file, "--database", there)
    assert "0 entries added, 0 were there already" in done.out
    assert done.code == 0


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (OSError(28, "No space left on device"), "No space left on device"),
        (ValueError("surprise"), "unexpected ValueError: surprise"),
    ],
)
def test_what_nobody_foresaw_is_one_message_too(
    tsd: Tsd, monkeypatch: pytest.MonkeyPatch, error: Exception, words: str
) -> None:
    def fail() -> None:
        raise error

    monkeypatch.setattr(robots, "robot_files", fail)
    monkeypatch.delenv(command_line.TRACEBACK, raising=False)
    done = tsd("robot", "list")
    assert (done.code, done.out) == (1, "")
    assert done.err.startswith("error: ")
    assert words in done.err
    assert "Traceback" not in done.err


def test_whoever_mends_a_defect_gets_the_traceback(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail() -> None:
        raise ValueError("surprise")

    monkeypatch.setattr(robots, "robot_files", fail)
    monkeypatch.setenv(command_line.TRACEBACK, "1")
    with pytest.raises(ValueError, match="surprise"):
        command_line.run(["robot", "list"])


# the signal comes when a module is looked for: from our first line to the last import
INTERRUPT_AT_IMPORT = """
import importlib.abc, os, signal, sys

module, sys.argv = sys.argv[1], ["tsd", "robot", "list"]

class Finder(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == module:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Finder())
from tsd_cli.__main__ import main
main()
"""
# the signal comes when all is done and the interpreter ends
INTERRUPT_AT_EXIT = """
import atexit, os, signal, sys
from tsd_cli.__main__ import main
atexit.register(lambda: os.kill(os.getpid(), signal.SIGINT))
sys.argv = ["tsd", "--version"]
main()
"""


def interrupted(program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", program, *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        # a shell's job in the background would have it ignored
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.default_int_handler),
    )


@pytest.mark.parametrize(
    "module",
    ["tsd_cli.command_line", "typer.main", "rich.console", "tsd_cli.actions.robots", "pinocchio"],
)
def test_an_interrupt_while_modules_load_ends_the_process_without_a_word(module: str) -> None:
    done = interrupted(INTERRUPT_AT_IMPORT, module)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


def test_an_interrupt_while_the_interpreter_ends_says_nothing() -> None:
    done = interrupted(INTERRUPT_AT_EXIT)
    assert (done.returncode, done.stderr) == (-signal.SIGINT, "")


def narrow_squats(document: Any) -> None:
    document["motions"]["squat"]["amplitude"] = [0.001, 0.011]


def test_what_nobody_typed_fits_the_robot(
    write_robot: Callable[..., Path], tsd: Tsd, tmp_path: Path
) -> None:
    file = str(write_robot(narrow_squats))
    # as far as the simulated robot: the motion was found to be one of the robot's before
    done = tsd("simulate", "squat", "--robot", file, "--controller", "local", "--hardware", "x")
    assert "note: amplitude 0.011 m, the largest for hermes_lower\n" in done.err
    assert "amplitude is" not in done.err
    done = tsd("simulate", "squat", "--amplitude", "0.03", "--robot", file, "--hardware", "x")
    assert "amplitude is 0.03, expected 0.001 to 0.011 m" in done.err
    shown = tsd("motion", "show", "squat", "--robot", file)
    row = next(line.split() for line in shown.out.splitlines() if line.startswith("amplitude"))
    assert row[2] == "0.011"


def test_a_check_ends_with_the_commands_that_come_next(
    write_robot: Callable[..., Path], tsd: Tsd
) -> None:
    file = write_robot()
    apart = file.with_name("my robot.yaml")
    file.rename(apart)
    done = tsd("robot", "check", str(apart), "--no-pictures")
    rest = f"squat --robot '{apart}' --controller local --model-error 0.1"
    lines = done.out.splitlines()
    assert f"next: tsd simulate {rest}" in lines
    assert lines[-1].strip() == f"tsd learn {rest} --rule stable --iterations 2"
    done = tsd("robot", "check", str(apart), "--no-pictures", "--json", "-")
    assert json.loads(done.out)["works"]


@pytest.mark.parametrize("can_draw", [True, False])
def test_pictures_of_a_check_say_nothing_between_the_json(
    robot: Robot, tsd: Tsd, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, can_draw: bool
) -> None:
    def drawn(_: Robot, postures: Any) -> Any:
        return np.zeros((len(postures), 4, 4, 3), np.uint8) if can_draw else None

    monkeypatch.setattr("tsd_cli.actions.examination.render_postures", drawn)
    folder = str(tmp_path / "check")
    done = tsd("robot", "check", str(robot.path), "--out", folder, "--json", "-")
    assert json.loads(done.out)["works"]
    assert (folder in done.err) is can_draw


def test_the_readme_has_every_exit_code(tsd: Tsd) -> None:
    readme = " ".join((Path(__file__).parents[2] / "README.md").read_text().split())
    listed = " ".join(tsd("--help").out.split()).split("Exit codes: ")[1]
    for code in re.findall(r"\b\d+\b(?= [a-z])", listed.split("interrupted")[0]):
        assert re.search(rf"Exit codes: [^.]*\b{code}\b", readme), code


def test_a_new_robot_ends_with_the_command_that_comes_next(
    small_humanoid: Callable[..., Path], tsd: Tsd
) -> None:
    out = small_humanoid().with_name("my robot.yaml")
    feet = ("--feet", "left_foot,right_foot")
    done = tsd("robot", "new", str(out.with_name("small.urdf")), *feet, "--out", str(out))
    assert done.out.splitlines()[-1] == f"next: tsd robot check '{out}'"
